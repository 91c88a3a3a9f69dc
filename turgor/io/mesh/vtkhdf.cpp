// [VTKHDF: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format]
#include "turgor/io/mesh/vtkhdf.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/io/mesh/mesh_space.hpp"

namespace turgor {

namespace {

const std::string kRoot = "/VTKHDF", kSteps = kRoot + "/Steps";

/// Keeps the first error of several writes.
struct Writing {
  Hdf5File& file;
  Status status = Done{};

  template <class T>
  void append(const std::string& name, std::span<const T> values, std::size_t columns = 1) {
    if (status) status = file.append<T>(kRoot + "/" + name, values, columns);
  }
  void append(const std::string& name, std::int64_t value) { append<std::int64_t>(name, {&value, 1}); }
};

/// Name without '/', which HDF5 takes for a path.
std::string link_name(std::string name) {
  std::replace(name.begin(), name.end(), '/', '|');
  return name;
}

std::span<const float> flat(const std::vector<Vec3>& vectors) {
  return {vectors.empty() ? nullptr : &vectors.front().x, 3 * vectors.size()};
}

}  // namespace

Result<VtkHdfSeries> VtkHdfSeries::create(const std::filesystem::path& path, MeshSpace space) {
  Result<Hdf5File> file = Hdf5File::create(path);
  if (!file) return file.error();
  constexpr std::array<std::int64_t, 2> kVersion{2, 0};
  Status status = file->make_group(kSteps);
  if (status) status = file->write_attribute(kRoot, "Version", std::span<const std::int64_t>(kVersion));
  if (status) status = file->write_ascii_attribute(kRoot, "Type", "UnstructuredGrid");
  if (status) status = file->write_attribute(kRoot, "Turgor", io::space_text(space));
  if (status) status = file->write_attribute(kRoot, "SPACE", io::frame_name(space));
  if (!status) return status.error();
  return VtkHdfSeries(std::move(*file), space);
}

Result<VtkHdfSeries> VtkHdfSeries::resume(const std::filesystem::path& path, MeshSpace space,
                                          VtkHdfProgress progress) {
  Result<Hdf5File> file = Hdf5File::open_to_write(path);
  if (!file) return file.error();
  return VtkHdfSeries(std::move(*file), space, std::move(progress));
}

Status VtkHdfSeries::add(double time, const TriMesh& mesh, const std::vector<VertexField>& fields) {
  constexpr std::uint8_t kVtkTriangle = 5;
  std::vector<std::int64_t> corners;
  for (const Int3 t : mesh.triangles) corners.insert(corners.end(), {t.x, t.y, t.z});
  if (Status status = add_cells(corners, 3, kVtkTriangle, mesh.vertices.size()); !status) return status;
  std::vector<VertexField> all = fields;
  if (mesh.normals.size() == mesh.vertices.size()) {
    all.push_back(vertex_field("normal", mesh.normals));
    all.back().is_direction = true;
  }
  return add_step(time, mesh.vertices, all);
}

Status VtkHdfSeries::add_points(double time, const std::vector<Vec3>& points,
                                const std::vector<VertexField>& fields) {
  constexpr std::uint8_t kVtkVertex = 1;
  std::vector<std::int64_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0);
  if (Status status = add_cells(corners, 1, kVtkVertex, points.size()); !status) return status;
  return add_step(time, points, fields);
}

Status VtkHdfSeries::add_cells(const std::vector<std::int64_t>& corners, int each, std::uint8_t type,
                               std::size_t points) {
  if (now_.blocks > 0 && corners == now_.corners && now_.block_points == std::int64_t(points)) return Done{};
  const auto cells = std::int64_t(corners.size()) / each;
  std::vector<std::int64_t> ends(std::size_t(cells) + 1);
  for (std::size_t c = 0; c < ends.size(); c++) ends[c] = std::int64_t(c) * each;
  const std::vector<std::uint8_t> types(std::size_t(cells), type);
  Writing out{file_};
  out.append("NumberOfPoints", std::int64_t(points));
  out.append("NumberOfCells", cells);
  out.append("NumberOfConnectivityIds", std::int64_t(corners.size()));
  out.append<std::int64_t>("Connectivity", corners);
  out.append<std::int64_t>("Offsets", ends);
  out.append<std::uint8_t>("Types", types);
  now_.corners = corners;
  now_.blocks++, now_.cells += cells, now_.block_cells = cells, now_.ids += std::int64_t(corners.size()),
                                      now_.block_points = std::int64_t(points);
  return out.status;
}

Status VtkHdfSeries::add_fields(const std::vector<VertexField>& fields, std::size_t points) {
  if (!now_.fields) {
    now_.fields = fields;
    for (VertexField& field : *now_.fields) field.values = {};
  }
  Writing out{file_};
  for (const VertexField& known : *now_.fields) {
    const auto now = std::find_if(fields.begin(), fields.end(),
                                  [&](const VertexField& field) { return field.name == known.name; });
    const std::size_t count = points * std::size_t(known.components);
    std::vector<float> values(count, std::numeric_limits<float>::quiet_NaN());
    if (now != fields.end()) {
      TURGOR_ASSERT(now->values.size() == count, "a field has one value a vertex, as in the first step");
      values = io::values_in_space(*now, space_);
    }
    const std::string name = link_name(io::name_in_space(known, space_));
    out.append<float>("PointData/" + name, values, std::size_t(known.components));
    out.append("Steps/PointDataOffsets/" + name, now_.points);
  }
  return out.status;
}

Status VtkHdfSeries::add_step(double time, const std::vector<Vec3>& positions,
                              const std::vector<VertexField>& fields) {
  if (Status status = add_fields(fields, positions.size()); !status) return status;
  Writing out{file_};
  out.append<float>("Points", flat(io::in_space(positions, space_)), 3);
  out.append<double>("Steps/Values", {&time, 1});
  out.append("Steps/PartOffsets", now_.blocks - 1);
  out.append("Steps/NumberOfParts", 1);
  out.append("Steps/PointOffsets", now_.points);
  out.append("Steps/CellOffsets", now_.cells - now_.block_cells);
  out.append("Steps/ConnectivityIdOffsets", now_.ids - std::int64_t(now_.corners.size()));
  now_.points += std::int64_t(positions.size());
  now_.steps++;
  return out.status;
}

Status VtkHdfSeries::close() {
  Status status = file_.write_attribute(kSteps, "NSteps", std::span<const std::int64_t>(&now_.steps, 1));
  if (!status) return status;
  return file_.close();
}

}  // namespace turgor
