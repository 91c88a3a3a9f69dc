// Surfaces over time in one file, for VTK 9.3 and ParaView 5.12: VTKHDF 2.0, an unstructured grid. Positions
// and fields grow by one entry per step; triangles are stored once as long as they do not change. For older
// programs mesh_files.hpp writes one .vtu per step.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/io/mesh/mesh_files.hpp"

namespace turgor {

/// Content of a series so far.
struct VtkHdfProgress {
  std::optional<std::vector<VertexField>> fields;  // of the first step, without values
  std::vector<std::int64_t> corners;               // of the latest cells
  std::int64_t steps = 0, blocks = 0;              // a block, VTKHDF's part, counts its cells and points once
  std::int64_t points = 0, block_points = 0;       // in all steps, and in the latest block
  std::int64_t cells = 0, block_cells = 0;         // in all blocks, and in the latest
  std::int64_t ids = 0;                            // corners of cells in all blocks
};

class VtkHdfSeries {
 public:
  static Result<VtkHdfSeries> create(const std::filesystem::path& path, MeshSpace space = {});

  /// Continues a flushed file that has this content.
  static Result<VtkHdfSeries> resume(const std::filesystem::path& path, MeshSpace space,
                                     VtkHdfProgress progress);

  /// Adds a step [s]. The first step defines the fields: a field that is missing later has no values, and a
  /// new one is ignored.
  Status add(double time, const TriMesh& mesh, const std::vector<VertexField>& fields);
  /// The same for points without a surface.
  Status add_points(double time, const std::vector<Vec3>& points, const std::vector<VertexField>& fields);
  const VtkHdfProgress& progress() const { return now_; }
  /// Data written so far survives a crash of the program.
  Status flush() { return file_.flush(); }
  /// Closes the file; it cannot be used afterwards.
  Status close();

 private:
  VtkHdfSeries(Hdf5File file, MeshSpace space, VtkHdfProgress now = {})
      : file_(std::move(file)), space_(space), now_(std::move(now)) {}
  Status add_cells(const std::vector<std::int64_t>& corners, int each, std::uint8_t type, std::size_t points);
  Status add_fields(const std::vector<VertexField>& fields, std::size_t points);
  Status add_step(double time, const std::vector<Vec3>& positions, const std::vector<VertexField>& fields);

  Hdf5File file_;
  MeshSpace space_;
  VtkHdfProgress now_;
};

}  // namespace turgor
