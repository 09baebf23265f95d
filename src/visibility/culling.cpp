#include "visibility/culling.h"

namespace dapple::visibility {

ListCulling::ListCulling(const gpuscene::Items& items, bool castersOnly, std::function<bool(uint32_t)> keep)
    : items_(items), hierarchy_(items.hierarchy(gpuscene::Items::kLeafTriangles, castersOnly)), keep_(std::move(keep)) {}

void ListCulling::draw(const ViewFrame& frame, const gpuscene::Submit& submit) {
    std::vector<uint32_t> chosen;
    hierarchy_.selectItems([&](const base::Box& box) { return frame.view.mayContain(frame.view.relative(box)); }, chosen);
    if (keep_) std::erase_if(chosen, [&](uint32_t item) { return !keep_(items_[item].instance); });
    items_.collect(frame.view.eye, chosen, list_);
    submit(list_);
}

void pickGroups(const gpuscene::ItemTable& table, const CullView& view, gpuscene::ItemTable::Groups& groups) {
    table.pick([&](const base::Box& box) { return view.mayContain(view.relative(box)); }, [&](const base::Box& box) { return view.key(view.relative(box)); }, groups);
}

}  // namespace dapple::visibility
