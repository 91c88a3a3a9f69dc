#include "turgor/geometry/labeled_component.hpp"

#include <algorithm>

#include "turgor/core/number_text.hpp"
#include "turgor/geometry/label_measures.hpp"

namespace turgor {

namespace {

constexpr std::size_t kNamedLabels = 12;  // listed in an error

std::string known_labels(const std::vector<LabelMeasure>& measures) {
  if (measures.empty()) return "it has no labels";
  std::string text = "it has ";
  for (std::size_t i = 0; i < std::min(measures.size(), kNamedLabels); i++)
    text += (i ? ", " : "") + std::to_string(measures[i].label) + " (" +
            number_text(measures[i].volume * 1e6) + " mL)";
  return text + (measures.size() > kNamedLabels ? ", …" : "");
}

Status check_labels_occur(const LabelVolume& labels, std::span<const int> chosen) {
  const std::vector<LabelMeasure> measures = measure_labels(labels, nullptr);
  if (chosen.empty()) return Error{"no label was chosen from the segmentation; " + known_labels(measures)};
  for (const int label : chosen)
    if (std::none_of(measures.begin(), measures.end(), [&](const auto& m) { return m.label == label; }))
      return Error{"label " + std::to_string(label) + " is not in the segmentation; " +
                   known_labels(measures)};
  return Done{};
}

/// Marks the connected component around a sample with `number`; returns its number of samples.
std::size_t mark_component(const Grid& grid, std::size_t start, int number, std::vector<int>& component) {
  std::vector<std::size_t> stack{start};
  component[start] = number;
  const std::size_t strides[3] = {1, std::size_t(grid.size.x),
                                  std::size_t(grid.size.x) * std::size_t(grid.size.y)};
  std::size_t count = 0;
  while (!stack.empty()) {
    const std::size_t at = stack.back();
    stack.pop_back();
    count++;
    for (int axis = 0; axis < 3; axis++) {
      const std::size_t index = at / strides[axis] % std::size_t(grid.size[axis]);
      const auto visit = [&](std::size_t next) {
        if (component[next] == 0) component[next] = number, stack.push_back(next);
      };
      if (index > 0) visit(at - strides[axis]);
      if (index + 1 < std::size_t(grid.size[axis])) visit(at + strides[axis]);
    }
  }
  return count;
}

/// "12 voxels at the ends of k", for every axis at whose ends the component touches the border.
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

Result<LabeledComponent> largest_labeled_component(const LabelVolume& labels, std::span<const int> chosen) {
  if (Status occur = check_labels_occur(labels, chosen); !occur) return occur.error();
  std::vector<int> component(labels.samples.size());  // -1: not chosen, 0: not yet assigned
  for (std::size_t i = 0; i < component.size(); i++)
    component[i] = std::find(chosen.begin(), chosen.end(), int(labels.samples[i])) == chosen.end() ? -1 : 0;
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < component.size(); i++)
    if (component[i] == 0) sizes.push_back(mark_component(labels.grid, i, int(sizes.size()) + 1, component));
  const auto largest = std::max_element(sizes.begin(), sizes.end());
  const int number = int(largest - sizes.begin()) + 1;
  LabeledComponent result{
      std::vector<std::uint8_t>(component.size()), double(*largest) * sample_volume(labels.grid), {}};
  for (std::size_t i = 0; i < component.size(); i++) result.inside[i] = component[i] == number;
  if (sizes.size() > 1) {
    std::size_t rest = 0;
    for (const std::size_t size : sizes) rest += size;
    const double volume = double(rest - *largest) * sample_volume(labels.grid);
    result.notes.push_back(std::to_string(sizes.size() - 1) +
                           (sizes.size() == 2 ? " smaller component with " : " smaller components with ") +
                           number_text(volume * 1e6) +
                           " mL ignored: a body is made of the largest component");
  }
  if (const std::string ends = border_note(labels.grid, result.inside); !ends.empty())
    result.notes.push_back("the labeled component reaches the border of the volume (" + ends +
                           "): it may be truncated");
  return result;
}

}  // namespace turgor
