#include "gpuscene/items.h"

#include "gpuscene/item_table.h"

#include <algorithm>
#include <cmath>

namespace dapple::gpuscene {

Items::Items(const scenegen::Scene& scene, std::vector<Part> parts) : scene_(&scene), parts_(std::move(parts)) {
    std::vector<uint32_t> first(scene.prototypes.size() + 1, 0);
    for (const Part& part : parts_) ++first[part.prototype + 1];
    for (size_t p = 1; p < first.size(); ++p) first[p] += first[p - 1];
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (uint32_t p = first[scene.instances[i].prototype]; p < first[scene.instances[i].prototype + 1]; ++p) items_.push_back({i, p});
    boxes_.resize(items_.size());
    instancesMoved();
}

void Items::instancesMoved() {
    std::vector<uint32_t> moved;
    std::vector<base::Box> movedBoxes;
    for (uint32_t i = 0; i < size(); ++i) {
        const base::Box box = scenegen::instanceBox(part(i).box, instance(i));
        if (box.lo != boxes_[i].lo || box.hi != boxes_[i].hi) {
            moved.push_back(i);
            movedBoxes.push_back(box);
        }
        boxes_[i] = box;
    }
    for (auto& [settings, hierarchy] : hierarchies_) hierarchy.refit(moved, movedBoxes);
    for (auto& [castersOnly, table] : tables_) table->upload();
}

const Hierarchy& Items::hierarchy(uint64_t leafTriangles, bool castersOnly) const {
    auto [entry, made] = hierarchies_.try_emplace({leafTriangles, castersOnly});
    if (made) {
        std::vector<base::Box> boxes;
        std::vector<uint32_t> triangles;
        for (uint32_t i = 0; i < size(); ++i) {
            boxes.push_back(castersOnly && !part(i).castsShadow ? base::Box{} : boxes_[i]);
            triangles.push_back(uint32_t(part(i).triangles));
        }
        entry->second = Hierarchy(boxes, triangles, {.leafTriangles = leafTriangles});
    }
    return entry->second;
}

const ItemTable& Items::table(bool castersOnly) const {
    std::shared_ptr<ItemTable>& table = tables_[castersOnly];
    if (!table) table = std::make_shared<ItemTable>(*this, castersOnly);
    return *table;
}

void Items::collect(const glm::dvec3& eye, std::span<const uint32_t> chosen, DrawList& list) const {
    struct Near {
        uint32_t item, part;
        double distance;
    };
    std::vector<Near> near;
    near.reserve(chosen.size());
    for (const uint32_t i : chosen) {
        const glm::dvec3 nearest = glm::clamp(eye, glm::dvec3(boxes_[i].lo), glm::dvec3(boxes_[i].hi));
        near.push_back({i, items_[i].part, glm::distance(nearest, eye)});
    }
    // Nearest first within a part, and parts by their nearest item: early depth rejection.
    std::sort(near.begin(), near.end(), [](const Near& a, const Near& b) {
        if (a.part != b.part) return a.part < b.part;
        return a.distance != b.distance ? a.distance < b.distance : a.item < b.item;
    });
    std::vector<std::span<const Near>> groups;
    for (auto begin = near.begin(); begin != near.end();) {
        const auto end = std::find_if(begin, near.end(), [&](const Near& n) { return n.part != begin->part; });
        groups.emplace_back(begin, end);
        begin = end;
    }
    std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.front().distance < b.front().distance; });
    list.parts = parts_;
    list.data.clear();
    list.items.clear();
    list.ranges.clear();
    for (const std::span<const Near> group : groups) {
        list.ranges.push_back({group.front().part, uint32_t(list.data.size()), uint32_t(group.size())});
        for (const Near& n : group) {
            const scenegen::Instance& at = instance(n.item);
            list.data.push_back({glm::vec3(glm::dvec3(at.translation) - eye), at.scale, {float(std::cos(double(at.yaw))), float(std::sin(double(at.yaw)))}});
            list.items.push_back(n.item);
        }
    }
    list.upload();
}

}  // namespace dapple::gpuscene
