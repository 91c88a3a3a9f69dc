#include "turgor/models/lattice/resample/resample.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "turgor/core/timing.hpp"
#include "turgor/geometry/ct_sampler.hpp"
#include "turgor/models/lattice/resample/deformed_body.hpp"
#include "turgor/models/lattice/resample/deformed_fields.hpp"
#include "turgor/models/lattice/resample/partial_volume.hpp"
#include "turgor/models/lattice/resample/rest_mass.hpp"
#include "turgor/models/lattice/resample/warp_outside.hpp"

namespace turgor::lattice {

namespace {

struct CtWriter {
  CtSampler sample;
  CtVolume& out;
  ResampleOptions options;
  const RestBody& rest;
  OutputToCt to_ct;
  std::int64_t mass = 0;           // Σ (HU + 1000) over the voxels of the body
  std::vector<RimVoxel> rim = {};  // possible sources of partial volume

  void tissue(Int3 cell, std::size_t voxel, Int3 p, Vec3 at, float ratio) {
    out.samples[voxel] = deformed_hu(sample(at), ratio, options.conserve_mass);
    mass += out.samples[voxel] - kAirHu;
    if (options.keep_surroundings && rest.is_near_air(cell)) rim.push_back({p, rim_shift(to_ct, p, at)});
  }
};

/// `Of` is a field of deformed_fields.hpp.
template <class Of, class Sample>
struct FieldWriter {
  Of of;
  std::vector<Sample>& out;

  void tissue(Int3, std::size_t voxel, Int3 p, Vec3 at, float ratio) { out[voxel] = of(p, at, ratio); }
};

struct Counts {
  long inverted_tets = 0, overlaps = 0;
};

/// Resamples one slab of output layers with its own writer. Marks the voxels that it covers.
template <class Writer>
Counts resample_slab(const DeformedBody& body, int slab, const RestFrame& rest, Writer& writer,
                     std::vector<std::uint8_t>& covered) {
  Counts counts;
  counts.inverted_tets = walk_slab(body, slab, rest, [&](Int3 cell, Int3 p, Vec3 at, float ratio) {
    const std::size_t voxel = sample_index(body.out, p.x, p.y, p.z);
    counts.overlaps += covered[voxel];
    if (covered[voxel]) return;
    covered[voxel] = 1;
    writer.tissue(cell, voxel, p, at, ratio);
  });
  return counts;
}

/// Result of all slabs: a writer for each, and the voxels that they cover.
template <class Writer>
struct Resampled {
  std::vector<Writer> slabs;
  std::vector<std::uint8_t> covered;  // by voxel
  Counts counts;
};
template <class Writer>
Resampled<Writer> resample_with(const Exec& exec, const DeformedBody& body, const RestFrame& rest,
                                const Writer& writer) {
  const auto slabs = std::size_t(slab_count(body));
  Resampled<Writer> all{
      std::vector<Writer>(slabs, writer), std::vector<std::uint8_t>(sample_count(body.out)), {}};
  std::vector<Counts> counts(slabs);
  parallel_for(exec, slabs, [&](std::size_t s) {
    counts[s] = resample_slab(body, int(s), rest, all.slabs[s], all.covered);
  });
  for (const Counts& c : counts)
    all.counts.inverted_tets += c.inverted_tets, all.counts.overlaps += c.overlaps;
  return all;
}

/// Fills the voxels without tissue: partial volume and surroundings, or air.
void fill_rest(const Exec& exec, const Model& model, const CtVolume& ct, const RestBody& rest,
               Resampled<CtWriter>& tissue, CtVolume& out) {
  if (tissue.slabs.empty()) return;
  // air only
  if (!tissue.slabs[0].options.keep_surroundings) {
    for (std::size_t v = 0; v < out.samples.size(); v++)
      if (!tissue.covered[v]) out.samples[v] = kAirHu;
    return;
  }
  // rims, then partial volume and surroundings
  std::vector<std::vector<RimVoxel>> rim;
  for (CtWriter& slab : tissue.slabs) rim.push_back(std::move(slab.rim));
  parallel_for(exec, rim.size(), [&](std::size_t s) { keep_rim(out.grid, tissue.covered, rim[s]); });
  const PartialVolumeInputs inputs{
      .model = model, .ct = ct, .rest = rest, .covered = tissue.covered, .rim = rim};
  parallel_for(exec, rim.size(), [&](std::size_t s) { fill_outside_body(inputs, int(s), out); });
}

template <class Sample, class Of>
std::vector<Sample> resample_field(const Exec& exec, const Model& model, const State& state, const Grid& out,
                                   const Of& of) {
  std::vector<Sample> samples(sample_count(out), Of::outside());
  resample_with(exec, deform_body(exec, model, state, out), kNodeUnits, FieldWriter<Of, Sample>{of, samples});
  return samples;
}

}  // namespace

Grid resized(const Grid& grid, Int3 size) {
  Grid result = grid;
  result.size = size;
  for (int axis = 0; axis < 3; axis++) result.spacing[axis] *= double(grid.size[axis]) / double(size[axis]);
  const auto first = [&](int axis) { return 0.5 * (double(grid.size[axis]) / double(size[axis]) - 1); };
  result.origin = point_at(grid, {first(0), first(1), first(2)});
  return result;
}

ResampledCt resample_ct(const Exec& exec, const Model& model, const State& state, const CtVolume& ct,
                        const Grid& out, const ResampleOptions& options) {
  const Timer timer;
  // tissue
  const RestFrame rest = rest_frame(model, ct.grid);
  ResampledCt result;
  result.ct.grid = out;
  result.ct.samples.resize(sample_count(out));
  const DeformedBody body = deform_body(exec, model, state, out);
  const RestBody at_rest(exec, model, rest.first_node, rest.cell_size);
  Resampled<CtWriter> tissue = resample_with(exec, body, rest,
                                             CtWriter{.sample = CtSampler(ct),
                                                      .out = result.ct,
                                                      .options = options,
                                                      .rest = at_rest,
                                                      .to_ct = OutputToCt(out, ct.grid)});
  // outside of the body
  fill_rest(exec, model, ct, at_rest, tissue, result.ct);
  // mass error
  double mass = 0;
  for (const CtWriter& slab : tissue.slabs) mass += double(slab.mass);
  mass *= sample_volume(out);
  const double before = rest_mass(exec, model, state.cuts, ct);
  result.report = {.seconds = timer.seconds(),
                   .mass_error = before > 0 ? (mass - before) / before : 0,
                   .inverted_tets = tissue.counts.inverted_tets,
                   .overlaps = tissue.counts.overlaps};
  return result;
}

VectorVolume resample_displacement(const Exec& exec, const Model& model, const State& state,
                                   const Grid& out) {
  const DisplacementOfVoxel of{model.anatomy.grid, out};
  return {.grid = out, .samples = resample_field<Vec3>(exec, model, state, out, of)};
}

VectorVolume resample_warp(const Exec& exec, const Model& model, const State& state, const Grid& out) {
  using Writer = FieldWriter<DisplacementOfVoxel, Vec3>;
  VectorVolume field{.grid = out, .samples = std::vector<Vec3>(sample_count(out))};
  const Writer writer{{model.anatomy.grid, out}, field.samples};
  const std::vector<std::uint8_t> covered =
      resample_with(exec, deform_body(exec, model, state, out), kNodeUnits, writer).covered;
  fill_warp_outside(exec, model, covered, field);
  return field;
}

ScalarVolume resample_jacobian(const Exec& exec, const Model& model, const State& state, const Grid& out) {
  return {.grid = out, .samples = resample_field<float>(exec, model, state, out, JacobianOfVoxel{})};
}

}  // namespace turgor::lattice
