// Quantities of reports: key in report.json, caption, unit and accessor, each stated once. Tables of
// quantities make report.json, the tables and key figures of report.html, and the summary in the terminal. A
// new measure needs a member and a row.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "turgor/core/assert.hpp"
#include "turgor/sim/report/json_numbers.hpp"

namespace turgor {

/// Suffix of keys, text of the unit, and factor from SI units.
struct Unit {
  const char* suffix;  // of keys: "mm" for "depth_mm"
  const char* text;    // "mm"
  double scale = 1;
};
namespace units {
inline constexpr Unit kNone{"", ""}, kCount{"", ""}, kDegrees{"deg", "°"}, kPercent{"percent", "%", 100};
inline constexpr Unit kSeconds{"s", "s"}, kMilliseconds{"ms", "ms", 1e3}, kMicroseconds{"us", "µs", 1e6};
inline constexpr Unit kMillimeters{"mm", "mm", 1e3}, kMeters{"m", "m"}, kSquareMillimeters{"mm2", "mm²", 1e6},
    kSquareMeters{"m2", "m²"}, kMillilitres{"ml", "ml", 1e6};
inline constexpr Unit kNewtons{"N", "N"}, kTorque{"Nm", "N·m"}, kTension{"N_per_m", "N/m"},
    kPascals{"Pa", "Pa"}, kJoules{"J", "J"}, kSpeed{"m_per_s", "m/s"}, kGrams{"g", "g", 1e3},
    kBytes{"bytes", "bytes"};
}  // namespace units

enum Visibility : unsigned {
  kInReport = 0,   // also the tables of report.html
  kInTable = 1,    // also the summary in the terminal
  kInSummary = 2,  // and the summary in the terminal
  kEverywhere = 3,
};

/// A quantity of a T.
template <class T>
struct Quantity {
  const char* key;  // without its unit; a dot leads into a table: "mesh.volume"
  Unit unit;
  const char* caption;   // without its unit
  Json (*of)(const T&);  // in SI units, a text or a whole number; null = unknown; absent() = not applicable
  unsigned shown_in = kInTable;
  const char* figure = "";  // label of a key figure of the page, such as "gape of {}"; "" = none
};

/// Value of a quantity that an item does not have; its key is omitted.
inline Json absent() { return Json(Json::value_t::discarded); }

/// "depth_mm"
inline std::string full_key(const char* key, const Unit& unit) {
  return *unit.suffix ? std::string(key) + "_" + unit.suffix : std::string(key);
}

/// Value in its own unit with six digits.
template <class T>
Json value_of(const Quantity<T>& quantity, const T& item) {
  Json value = quantity.of(item);
  if (value.is_number_float()) value = rounded(value.template get<double>() * quantity.unit.scale);
  return value;
}

/// Sets the value of a key, which may lead into tables.
void put(Json& json, const std::string& key, Json value);
/// Value of such a key; null if missing.
const Json* find(const Json& json, std::string_view key);

template <class T, std::size_t N>
Json values_of(const Quantity<T> (&quantities)[N], const T& item) {
  Json json;
  for (const Quantity<T>& q : quantities)
    if (Json value = value_of(q, item); !value.is_discarded())
      put(json, full_key(q.key, q.unit), std::move(value));
  return json;
}

/// Table with every `stride`-th of `items` as a row, and the keys of its columns.
template <class T, std::size_t N, class List>
void add_rows(Json& json, const char* columns_key, const char* rows_key, const Quantity<T> (&columns)[N],
              const List& items, std::size_t stride = 1) {
  TURGOR_CHECK(stride > 0, "rows advance");
  Json keys = Json::array(), rows = Json::array();
  for (const Quantity<T>& c : columns) keys.push_back(full_key(c.key, c.unit));
  for (std::size_t i = 0; i < items.size(); i += stride) {
    Json row = Json::array();
    for (const Quantity<T>& c : columns) {
      Json value = value_of(c, items[i]);
      row.push_back(value.is_discarded() ? Json() : std::move(value));
    }
    rows.push_back(std::move(row));
  }
  json[columns_key] = std::move(keys), json[rows_key] = std::move(rows);
}

/// Presentation of a quantity for pages and summaries, without its accessor.
struct Caption {
  std::string key, label;
  Unit unit;
  unsigned shown_in;
  std::string figure;
};
template <class T, std::size_t N>
std::vector<Caption> captions_of(const Quantity<T> (&quantities)[N]) {
  std::vector<Caption> captions;
  for (const Quantity<T>& q : quantities)
    captions.push_back({full_key(q.key, q.unit), q.caption, q.unit, q.shown_in, q.figure});
  return captions;
}

}  // namespace turgor
