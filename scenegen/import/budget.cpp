#include "scenegen/import/budget.h"

#include "base/error.h"

#include <fmt/format.h>

namespace dapple::scenegen {

Budget::Budget(std::filesystem::path file, const Limits& limits) : file_(std::move(file)), limits_(limits), seconds_(limits.seconds) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file_, error);
    if (!error) seconds_ += double(size) / 1e6;
}

void Budget::spend(size_t& spent, size_t more, size_t limit, const char* what) {
    if (more > limit || spent > limit - more)
        throw base::UsageError(fmt::format("{}: asks for more than {} {}, which is more than a scene file may", file_.string(), limit, what));
    spent += more;
}

void Budget::nodes(size_t more) { spend(nodes_, more, limits_.nodes, "nodes"); }
void Budget::triangles(size_t more) { spend(triangles_, more, limits_.triangles, "triangles"); }
void Budget::instances(size_t more) { spend(instances_, more, limits_.instances, "instances"); }

void Budget::texels(size_t width, size_t height) {
    if (height != 0 && width > limits_.texels / height) width = limits_.texels + 1, height = 1;  // the product may not fit
    spend(texels_, width * height, limits_.texels, "texels");
}

void Budget::bytes(size_t ofOneArray) const {
    if (ofOneArray > limits_.bytes)
        throw base::UsageError(fmt::format("{}: asks for {} bytes in one piece, where {} are allowed", file_.string(), ofOneArray, limits_.bytes));
}

void Budget::time() const {
    const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    if (spent > seconds_)
        throw base::UsageError(fmt::format("{}: reading it takes longer than {:.0f} s, which is too long for a file of its size", file_.string(), seconds_));
}

}  // namespace dapple::scenegen
