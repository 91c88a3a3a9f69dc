#include "turgor/geometry/labeled_component.hpp"

#include <algorithm>
#include <map>

#include "turgor/core/assert.hpp"
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

/// Box of the voxels inside: `low` included, `high` excluded.
struct InsideBox {
  Int3 low, high;
};

template <class Visit>
void for_each_index(Int3 size, const Visit& visit) {
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) visit(Int3{i, j, k});
}

InsideBox box_of(const Grid& grid, const std::vector<std::uint8_t>& inside) {
  InsideBox box{grid.size, {}};
  for_each_index(grid.size, [&](Int3 p) {
    if (inside[sample_index(grid, p.x, p.y, p.z)])
      box.low = min(box.low, p), box.high = max(box.high, p + Int3{1, 1, 1});
  });
  return box;
}

/// Calls visit(voxel) for all voxels that are not inside and have no path over faces to the faces of the box
/// around the voxels inside.
template <class Visit>
void for_each_enclosed(const Grid& grid, const std::vector<std::uint8_t>& inside, const Visit& visit) {
  TURGOR_CHECK(inside.size() == sample_count(grid), "every voxel is inside or not");
  const InsideBox box = box_of(grid, inside);
  if (box.high.x == 0) return;
  // voxels of the box: -1 inside, 0 not reached from the box's faces, 1 reached
  Grid crop = grid;
  crop.size = box.high - box.low;
  std::vector<int> reached(sample_count(crop));
  for_each_index(crop.size, [&](Int3 p) {
    const Int3 q = p + box.low;
    reached[sample_index(crop, p.x, p.y, p.z)] = inside[sample_index(grid, q.x, q.y, q.z)] ? -1 : 0;
  });
  for_each_index(crop.size, [&](Int3 p) {
    const std::size_t start = sample_index(crop, p.x, p.y, p.z);
    const Int3 last = crop.size - Int3{1, 1, 1};
    const bool at_face = p.x == 0 || p.y == 0 || p.z == 0 || p.x == last.x || p.y == last.y || p.z == last.z;
    if (at_face && reached[start] == 0) mark_component(crop, start, 1, reached);
  });
  // what was not reached
  for_each_index(crop.size, [&](Int3 p) {
    if (reached[sample_index(crop, p.x, p.y, p.z)] == 0) visit(p + box.low);
  });
}

std::vector<EnclosedLabel> with_volumes(const std::map<int, std::size_t>& voxels, const Grid& grid) {
  std::vector<EnclosedLabel> enclosed;
  for (const auto& [label, count] : voxels) enclosed.push_back({label, double(count) * sample_volume(grid)});
  return enclosed;
}

}  // namespace

std::vector<EnclosedLabel> enclosed_labels(const LabelVolume& labels,
                                           const std::vector<std::uint8_t>& inside) {
  std::map<int, std::size_t> voxels;
  for_each_enclosed(labels.grid, inside, [&](Int3 p) { voxels[int(labels.at(p.x, p.y, p.z))]++; });
  return with_volumes(voxels, labels.grid);
}

std::vector<EnclosedLabel> fill_cavities(const LabelVolume& labels, std::span<const int> kept_out,
                                         LabeledComponent& component) {
  std::map<int, std::size_t> voxels;
  for_each_enclosed(labels.grid, component.inside, [&](Int3 p) {
    const int label = int(labels.at(p.x, p.y, p.z));
    if (std::find(kept_out.begin(), kept_out.end(), label) != kept_out.end()) return;
    component.inside[sample_index(labels.grid, p.x, p.y, p.z)] = 1;
    voxels[label]++;
  });
  const std::vector<EnclosedLabel> filled = with_volumes(voxels, labels.grid);
  for (const EnclosedLabel& one : filled) component.volume += one.volume;
  return filled;
}

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
