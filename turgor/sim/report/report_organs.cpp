#include "turgor/sim/report/report_organs.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/invariants.hpp"
#include "turgor/sim/organs/free_lattice.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/report/section.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

using namespace units;

std::string between_text(const std::array<std::string, 2>& between) { return between[0] + ", " + between[1]; }

const CouplingSample& strongest_sample(const std::vector<CouplingSample>& samples) {
  static const CouplingSample kNone;
  const auto found = std::max_element(
      samples.begin(), samples.end(),
      [](const CouplingSample& a, const CouplingSample& b) { return norm(a.force) < norm(b.force); });
  return found == samples.end() ? kNone : *found;
}

int broken_count(const Attachment& attachment) {
  return int(std::count_if(attachment.ties.begin(), attachment.ties.end(),
                           [](const contact::Tie& tie) { return tie.broken; }));
}

/// intact, torn in part, or torn
std::string condition_of(const Attachment& attachment) {
  const int broken = broken_count(attachment);
  if (broken == 0) return "intact";
  return broken == int(attachment.ties.size()) ? "torn" : "torn in part";
}

CouplingSample last_sample(const std::vector<CouplingSample>& samples) {
  return samples.empty() ? CouplingSample{} : samples.back();
}

using Held = Attachment;
const Quantity<Held> kAttachment[] = {
    {"name", kNone, "", [](const Held& a) -> Json { return a.name; }, kInReport},
    {"between", kNone, "between", [](const Held& a) -> Json { return between_text(a.between); }},
    {"force", kNewtons, "force at the end",
     [](const Held& a) -> Json { return norm(last_sample(a.samples).force); }, kEverywhere,
     "force of {} at the end"},
    {"force_x", kNewtons, "", [](const Held& a) -> Json { return last_sample(a.samples).force.x; },
     kInReport},
    {"force_y", kNewtons, "", [](const Held& a) -> Json { return last_sample(a.samples).force.y; },
     kInReport},
    {"force_z", kNewtons, "", [](const Held& a) -> Json { return last_sample(a.samples).force.z; },
     kInReport},
    {"force_max", kNewtons, "largest force",
     [](const Held& a) -> Json { return norm(strongest_sample(a.samples).force); }, kEverywhere},
    {"force_max_at", kSeconds, "… at",
     [](const Held& a) -> Json { return strongest_sample(a.samples).time; }},
    {"springs", kCount, "springs", [](const Held& a) -> Json { return a.ties.size(); }},
    {"area", kSquareMillimeters, "tied surface", [](const Held& a) -> Json { return a.area; }},
    {"stiffness", kTension, "stiffness", [](const Held& a) -> Json { return a.stiffness; }},
    {"broken", kCount, "broken springs", [](const Held& a) -> Json { return broken_count(a); }},
    {"condition", kNone, "condition", [](const Held& a) -> Json { return condition_of(a); }, kEverywhere},
    {"torn_at", kSeconds, "first spring broke at",
     [](const Held& a) { return a.torn_at > 0 ? Json(a.torn_at) : absent(); }},
};

using Touching = BodyContact;
const Quantity<Touching> kBodyContact[] = {
    {"name", kNone, "", [](const Touching& c) -> Json { return c.name; }, kInReport},
    {"between", kNone, "between", [](const Touching& c) -> Json { return between_text(c.between); }},
    {"force", kNewtons, "force at the end",
     [](const Touching& c) -> Json { return norm(last_sample(c.samples).force); }, kEverywhere,
     "force of {} at the end"},
    {"force_x", kNewtons, "", [](const Touching& c) -> Json { return last_sample(c.samples).force.x; },
     kInReport},
    {"force_y", kNewtons, "", [](const Touching& c) -> Json { return last_sample(c.samples).force.y; },
     kInReport},
    {"force_z", kNewtons, "", [](const Touching& c) -> Json { return last_sample(c.samples).force.z; },
     kInReport},
    {"force_max", kNewtons, "largest force",
     [](const Touching& c) -> Json { return norm(strongest_sample(c.samples).force); }, kEverywhere},
    {"force_max_at", kSeconds, "… at",
     [](const Touching& c) -> Json { return strongest_sample(c.samples).time; }},
    {"friction", kNone, "friction", [](const Touching& c) -> Json { return c.params.friction; }},
    {"sites", kCount, "sites that bear force, at the end",
     [](const Touching& c) -> Json { return last_sample(c.samples).bearing; }},
    {"sliding", kCount, "… sliding",
     [](const Touching& c) -> Json { return last_sample(c.samples).sliding; }},
    {"overlap_max", kMillimeters, "largest overlap before it was removed",
     [](const Touching& c) -> Json { return c.deepest; }},
    {"dropped_most", kCount, "", [](const Touching& c) -> Json { return c.dropped_most; }, kInReport},
};

const Quantity<CouplingSample> kCouplingSeries[] = {
    {"time", kSeconds, "time", [](const CouplingSample& s) -> Json { return s.time; }},
    {"force", kNewtons, "force", [](const CouplingSample& s) -> Json { return norm(s.force); }},
    {"force_x", kNewtons, "", [](const CouplingSample& s) -> Json { return s.force.x; }},
    {"force_y", kNewtons, "", [](const CouplingSample& s) -> Json { return s.force.y; }},
    {"force_z", kNewtons, "", [](const CouplingSample& s) -> Json { return s.force.z; }},
    {"most", kNewtons, "largest single force", [](const CouplingSample& s) -> Json { return s.most; }},
    {"bearing", kCount, "bearing", [](const CouplingSample& s) -> Json { return s.bearing; }},
    {"sliding", kCount, "sliding", [](const CouplingSample& s) -> Json { return s.sliding; }},
};

/// One item of the report, with its series thinned out.
template <class T, std::size_t N>
Json coupling_item(const Quantity<T> (&quantities)[N], const T& item) {
  constexpr std::size_t kMostRows = 2000;
  Json json = values_of(quantities, item);
  add_rows(json, "series_columns", "series", kCouplingSeries, item.samples,
           std::max<std::size_t>(1, (item.samples.size() + kMostRows - 1) / kMostRows));
  return json;
}

}  // namespace

Json attachment_report(const World& world) {
  Json items = Json::array();
  for (const Attachment& a : world.coupling.attachments) items.push_back(coupling_item(kAttachment, a));
  return items;
}
Json body_contact_report(const World& world) {
  Json items = Json::array();
  for (const BodyContact& c : world.coupling.contacts) items.push_back(coupling_item(kBodyContact, c));
  return items;
}

Section attachment_section() {
  return {"Attachments", "attachment", [](const Json& report) { return items_of(report, "attachments"); },
          captions_of(kAttachment), true};
}
Section body_contact_section() {
  return {"Contact between bodies", "contact",
          [](const Json& report) { return items_of(report, "body_contacts"); }, captions_of(kBodyContact),
          true};
}

namespace {

/// True for contact of a lattice that nothing fixes with a body of elements, if needles, cloth, lattices or
/// the ground also act on it: its motion as a whole is not solved with the forces then.
bool is_free_on_elements(const World& world, const BodyContact& contact) {
  for (const int side : {0, 1}) {
    const int index = contact.body[std::size_t(side)], other = contact.body[std::size_t(1 - side)];
    const int support = index - first_support(world);
    if (!is_index(support, world.coupling.supports.size()) || !is_index(other, world.sfem_bodies.size()))
      continue;
    const CoupledSupport& body = world.coupling.supports[std::size_t(support)];
    if (body.body.kind == BodyKind::kLattice && body.free_mass > 0 && !moves_whole(world, body)) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> coupling_warnings(const World& world) {
  std::vector<std::string> warnings;
  const Coupling& coupling = world.coupling;
  if (coupling.unsolved > 0)
    warnings.push_back(fmt::format("the forces between bodies did not converge in {} of {} frames",
                                   coupling.unsolved, coupling.frames));
  for (const BodyContact& contact : coupling.contacts)
    if (is_free_on_elements(world, contact))
      warnings.push_back(fmt::format(
          "{}: a lattice that nothing fixes, and that needles, cloth, lattices or the ground also act on, "
          "feels a body of elements a few frames late and may pass through it or be thrown; fix a "
          "part of it, or make both bodies lattices",
          contact.name));
  for (const BodyContact& contact : coupling.contacts)
    if (contact.dropped_most > 0)
      warnings.push_back(fmt::format(
          "{}: up to {} touching vertices had no contact site, the surfaces may overlap there; raise "
          "contact.{}.sites",
          contact.name, contact.dropped_most, contact.name));
  return warnings;
}

}  // namespace turgor
