#include "turgor/geometry/labeled_component.hpp"

#include <algorithm>

#include "turgor/core/number_text.hpp"
#include "turgor/geometry/label_measures.hpp"

namespace turgor {

namespace {

constexpr std::size_t kNamedLabels = 12;  // in an error

std::string known_labels(const std::vector<LabelMeasure>& measures) {
  if (measures.empty()) return "it has none at all";
  std::string text = "it has ";
  for (std::size_t i = 0; i < std::min(measures.size(), kNamedLabels); i++)
    text += (i ? ", " : "") + std::to_string(measures[i].label) + " (" +
            number_text(measures[i].volume * 1e6) + " mL)";
  return text + (measures.size() > kNamedLabels ? ", …" : "");
}

Status check_labels_occur(const LabelVolume& labels, std::span<const int> wanted) {
  const std::vector<LabelMeasure> measures = measure_labels(labels, nullptr);
  if (wanted.empty()) return Error{"no label was chosen from the segmentation; " + known_labels(measures)};
  for (const int label : wanted)
    if (std::none_of(measures.begin(), measures.end(), [&](const auto& m) { return m.label == label; }))
      return Error{"label " + std::to_string(label) + " is not in the segmentation; " +
                   known_labels(measures)};
  return Done{};
}

/// Numbers the connected part around a sample in `part`; how many samples it has.
std::size_t mark_part(const Grid& grid, std::size_t start, int number, std::vector<int>& part) {
  std::vector<std::size_t> stack{start};
  part[start] = number;
  const std::size_t strides[3] = {1, std::size_t(grid.size.x),
                                  std::size_t(grid.size.x) * std::size_t(grid.size.y)};
  std::size_t count = 0;
  while (!stack.empty()) {
    const std::size_t at = stack.back();
    stack.pop_back();
    count++;
    for (int axis = 0; axis < 3; axis++) {
      const std::size_t place = at / strides[axis] % std::size_t(grid.size[axis]);
      const auto visit = [&](std::size_t next) {
        if (part[next] == 0) part[next] = number, stack.push_back(next);
      };
      if (place > 0) visit(at - strides[axis]);
      if (place + 1 < std::size_t(grid.size[axis])) visit(at + strides[axis]);
    }
  }
  return count;
}

/// "12 voxels at the ends of k", for every axis at whose ends the part lies.
std::string border_note(const Grid& grid, const std::vector<std::uint8_t>& inside) {
  std::size_t touching[3] = {};
  for (int k = 0; k < grid.size.z; k++)
    for (int j = 0; j < grid.size.y; j++)
      for (int i = 0; i < grid.size.x; i++) {
        if (!inside[sample_index(grid, i, j, k)]) continue;
        const Int3 p{i, j, k};
        for (int axis = 0; axis < 3; axis++) touching[axis] += p[axis] == 0 || p[axis] == grid.size[axis] - 1;
      }
  std::string text;
  for (int axis = 0; axis < 3; axis++)
    if (touching[axis] > 0)
      text += (text.empty() ? "" : ", ") + std::to_string(touching[axis]) +
              (touching[axis] == 1 ? " voxel" : " voxels") + " at the ends of " + "ijk"[axis];
  return text;
}

}  // namespace

Result<LabeledPart> largest_labeled_part(const LabelVolume& labels, std::span<const int> wanted) {
  if (Status occur = check_labels_occur(labels, wanted); !occur) return occur.error();
  std::vector<int> part(labels.samples.size());  // -1: not wanted, 0: not yet in a part
  for (std::size_t i = 0; i < part.size(); i++)
    part[i] = std::find(wanted.begin(), wanted.end(), int(labels.samples[i])) == wanted.end() ? -1 : 0;
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < part.size(); i++)
    if (part[i] == 0) sizes.push_back(mark_part(labels.grid, i, int(sizes.size()) + 1, part));
  const auto largest = std::max_element(sizes.begin(), sizes.end());
  const int number = int(largest - sizes.begin()) + 1;
  LabeledPart result{
      std::vector<std::uint8_t>(part.size()), double(*largest) * sample_volume(labels.grid), {}};
  for (std::size_t i = 0; i < part.size(); i++) result.inside[i] = part[i] == number;
  if (sizes.size() > 1) {
    std::size_t rest = 0;
    for (const std::size_t size : sizes) rest += size;
    const double volume = double(rest - *largest) * sample_volume(labels.grid);
    result.notes.push_back(std::to_string(sizes.size() - 1) +
                           (sizes.size() == 2 ? " smaller part with " : " smaller parts with ") +
                           number_text(volume * 1e6) + " mL left out: a body is made of the largest part");
  }
  if (const std::string ends = border_note(labels.grid, result.inside); !ends.empty())
    result.notes.push_back("the labelled part reaches the border of the volume (" + ends +
                           "): it may be cut off there");
  return result;
}

}  // namespace turgor
