#include "visibility/culling.h"

namespace dapple::visibility {

ListCulling::ListCulling(const gpuscene::Items& items, bool castersOnly) : items_(items), hierarchy_(items.hierarchy(gpuscene::Items::kLeafTriangles, castersOnly)) {}

void ListCulling::draw(const ViewFrame& frame, const gpuscene::Submit& submit) {
    std::vector<uint32_t> chosen;
    hierarchy_.selectItems([&](const base::Box& box) { return frame.view.mayContain(frame.view.relative(box)); }, chosen);
    items_.collect(frame.view.eye, chosen, list_);
    submit(list_);
}

}  // namespace dapple::visibility
