#include "scenegen/terrain/holes.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

constexpr int kSweeps = 16;  // per level: the levels below start from a good guess

/// Halves of the grid above; a cell is known where a sample that it covers is.
struct Level {
    int width, height;
    std::vector<float> values;
    std::vector<bool> holes;
};

Level halved(const Level& fine) {
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
    for (int y = 0; y < coarse.height; ++y)
        for (int x = 0; x < coarse.width; ++x) {
            double sum = 0;
            int known = 0;
            for (int j = 2 * y; j < std::min(2 * y + 2, fine.height); ++j)
                for (int i = 2 * x; i < std::min(2 * x + 2, fine.width); ++i)
                    if (const size_t at = size_t(j) * size_t(fine.width) + size_t(i); !fine.holes[at])
                        sum += fine.values[at], ++known;
            coarse.values.push_back(known ? float(sum / known) : 0);
            coarse.holes.push_back(known == 0);
        }
    return coarse;
}

/// Gauss-Seidel on the holes; beyond the border lies what lies at the border.
void relax(Level& level) {
    std::vector<size_t> holes;
    for (size_t i = 0; i < level.holes.size(); ++i)
        if (level.holes[i]) holes.push_back(i);
    const auto width = size_t(level.width), size = level.values.size();
    for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (const size_t i : holes) {
            const size_t x = i % width;
            double sum = 0;
            int count = 0;
            if (x > 0) sum += level.values[i - 1], ++count;
            if (x + 1 < width) sum += level.values[i + 1], ++count;
            if (i >= width) sum += level.values[i - width], ++count;
            if (i + width < size) sum += level.values[i + width], ++count;
            if (count > 0) level.values[i] = float(sum / count);
        }
}

}  // namespace

std::vector<bool> holesOf(const base::ImageF& heights) {
    constexpr double kMarks[] = {-9999, -32768, -32767, -99999, -999999};
    std::vector<bool> isHeight(std::size(kMarks));
    const auto isMark = [&](double v) {
        return std::find(std::begin(kMarks), std::end(kMarks), v) != std::end(kMarks);
    };
    for (const float v : heights.texels)
        for (size_t m = 0; m < std::size(kMarks); ++m)
            if (std::abs(double(v) - kMarks[m]) <= -0.01 * kMarks[m] && !isMark(double(v))) isHeight[m] = true;
    std::vector<bool> holes;
    for (const float v : heights.texels) {
        bool isHole = !(std::abs(v) < 1e20f);
        for (size_t m = 0; m < std::size(kMarks); ++m) isHole = isHole || (double(v) == kMarks[m] && !isHeight[m]);
        holes.push_back(isHole);
    }
    return holes;
}

void fillHoles(base::ImageF& heights, const std::vector<bool>& holes) {
    std::vector<Level> levels{{heights.width, heights.height, std::move(heights.texels), holes}};
    const auto hasHoles = [](const Level& l) {
        return std::find(l.holes.begin(), l.holes.end(), true) != l.holes.end();
    };
    while (hasHoles(levels.back())) levels.push_back(halved(levels.back()));
    for (size_t l = levels.size() - 1; l-- > 0;) {
        Level& fine = levels[l];
        const Level& coarse = levels[l + 1];
        for (int y = 0; y < fine.height; ++y)
            for (int x = 0; x < fine.width; ++x)
                if (const size_t at = size_t(y) * size_t(fine.width) + size_t(x); fine.holes[at])
                    fine.values[at] = coarse.values[size_t(y / 2) * size_t(coarse.width) + size_t(x / 2)];
        relax(fine);
    }
    heights.texels = std::move(levels[0].values);
}

}  // namespace dapple::scenegen
