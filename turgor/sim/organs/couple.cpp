#include <algorithm>
#include <numeric>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// 1 for every body that an attachment or a contact concerns.
std::vector<std::uint8_t> coupled_bodies(const World& world) {
  std::vector<std::uint8_t> coupled(world.sfem_bodies.size(), 0);
  for (const Attachment& attachment : world.coupling.attachments)
    for (const contact::Tie& tie : attachment.ties)
      for (const int body : {tie.a.body, tie.b.body})
        if (body >= 0) coupled[std::size_t(body)] = 1;
  for (const BodyContact& contact : world.coupling.contacts)
    for (const int body : contact.body) coupled[std::size_t(body)] = 1;
  return coupled;
}

/// Positions of all vertices at the end of the frame.
std::vector<Vec3d> positions_now(const SfemBody& body, const std::vector<Vec3d>& by_tools) {
  std::vector<Vec3d> x = body.model.body.mesh.vertices;
  for (std::size_t v = 0; v < x.size(); v++) x[v] += by_tools[v];
  for (std::size_t v = 0; v < body.free.before.size(); v++) x[v] += body.free.before[v];
  return x;
}

/// Finds the sites of a contact at the present positions.
void update_sites(const Exec& exec, const World& world, const std::vector<std::vector<Vec3d>>& x,
                  BodyContact& contact) {
  std::array<contact::PairSurface, 2> surfaces;
  for (std::size_t side = 0; side < 2; side++) {
    const auto b = std::size_t(contact.body[side]);
    const sfem::Model& model = world.sfem_bodies[b].model;
    surfaces[side] = {contact.body[side], model.body.mesh.vertices, x[b], model.surface.triangles,
                      contact.rest_height[side]};
  }
  contact::PairSites found = contact::find_pair_sites(exec, surfaces, contact.params, contact.sites);
  contact.sites = std::move(found.sites);
  contact.dropped_most = std::max(contact.dropped_most, found.dropped);
  contact.deepest = std::max(contact.deepest, found.deepest);
}

CouplingSample sample_of(double time, const std::vector<contact::Tie>& ties) {
  CouplingSample sample{.time = time, .force = total_force(ties)};
  for (const contact::Tie& tie : ties)
    sample.most = std::max(sample.most, norm(tie.force)), sample.bearing += tie.force != Vec3d{};
  return sample;
}
CouplingSample sample_of(double time, const std::vector<contact::PairSite>& sites, int body) {
  CouplingSample sample{.time = time, .force = total_force(sites, body)};
  for (const contact::PairSite& site : sites) {
    sample.most = std::max(sample.most, norm(site.force)), sample.bearing += site.force != Vec3d{};
    sample.sliding += site.state == contact::SiteState::kSlip;
  }
  return sample;
}

/// All ties and sites in one list, solved, and put back.
contact::CouplingReport solve_all(const Exec& exec, const std::vector<contact::CoupledBody>& bodies,
                                  Coupling& coupling, std::vector<contact::Tie>& ties,
                                  std::vector<contact::PairSite>& sites) {
  for (const Attachment& a : coupling.attachments) ties.insert(ties.end(), a.ties.begin(), a.ties.end());
  for (const BodyContact& c : coupling.contacts) sites.insert(sites.end(), c.sites.begin(), c.sites.end());
  const contact::CouplingReport report = contact::solve_coupling(exec, bodies, ties, sites);
  auto tie = ties.begin();
  for (Attachment& a : coupling.attachments)
    std::copy_n(tie, a.ties.size(), a.ties.begin()), tie += std::ptrdiff_t(a.ties.size());
  auto site = sites.begin();
  for (BodyContact& c : coupling.contacts)
    std::copy_n(site, c.sites.size(), c.sites.begin()), site += std::ptrdiff_t(c.sites.size());
  return report;
}

}  // namespace

Vec3d total_force(const std::vector<contact::Tie>& ties) {
  return std::accumulate(ties.begin(), ties.end(), Vec3d{},
                         [](Vec3d sum, const contact::Tie& tie) { return sum + tie.force; });
}
Vec3d total_force(const std::vector<contact::PairSite>& sites, int body) {
  Vec3d sum;
  for (const contact::PairSite& site : sites)
    sum += site.a.body == body ? site.force : site.b.body == body ? -site.force : Vec3d{};
  return sum;
}

void couple_bodies(const Exec& exec, World& world) {
  Coupling& coupling = world.coupling;
  const std::vector<std::uint8_t> coupled = coupled_bodies(world);

  // displacements by tools, positions at the end of this frame, and the free motion of the next
  const std::size_t count = world.sfem_bodies.size();
  std::vector<contact::CoupledBody> bodies(count);
  std::vector<std::vector<Vec3d>> x(count);
  for (std::size_t b = 0; b < count; b++) {
    SfemBody& body = world.sfem_bodies[b];
    if (!coupled[b] && !body.flight) continue;
    std::vector<Vec3d> by_tools = tool_displacement(exec, body);
    x[b] = positions_now(body, by_tools);
    if (body.flight) advance_flight(body, by_tools, world.gravity, world.dt);
    bodies[b] = {&body.model, body.stiffness_scale, uncoupled_displacement(body, std::move(by_tools))};
    if (!coupled[b]) sum_free_motion(body);
  }
  if (is_empty(coupling)) return;

  // sites and forces
  for (BodyContact& contact : coupling.contacts) update_sites(exec, world, x, contact);
  std::vector<contact::Tie> ties;
  std::vector<contact::PairSite> sites;
  const contact::CouplingReport report = solve_all(exec, bodies, coupling, ties, sites);
  coupling.frames++, coupling.unsolved += !report.converged;

  // motion that they cause
  for (std::size_t b = 0; b < count; b++)
    if (coupled[b]) couple_body(exec, world.sfem_bodies[b], contact::forces_on(int(b), ties, sites));

  // record at the end of this frame
  const double time = (world.frame + 1) * world.dt;
  for (Attachment& attachment : coupling.attachments) {
    attachment.samples.push_back(sample_of(time, attachment.ties));
    const bool is_torn = std::any_of(attachment.ties.begin(), attachment.ties.end(),
                                     [](const contact::Tie& tie) { return tie.broken; });
    if (is_torn && attachment.torn_at == 0) attachment.torn_at = time;
  }
  for (BodyContact& contact : coupling.contacts)
    contact.samples.push_back(sample_of(time, contact.sites, contact.body[0]));
}

std::uint64_t state_hash(const Coupling& coupling, std::uint64_t seed) {
  for (const Attachment& attachment : coupling.attachments)
    for (const contact::Tie& tie : attachment.ties) seed = hash_bytes(&tie.force, sizeof tie.force, seed);
  for (const BodyContact& contact : coupling.contacts)
    for (const contact::PairSite& site : contact.sites)
      seed = hash_bytes(&site.force, sizeof site.force, seed);
  return seed;
}

}  // namespace turgor
