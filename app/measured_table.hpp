// Comparison with measured values: a table "measured [band] | predicted | inside?", and its JSON.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "app/validation.hpp"

namespace turgor {

/// A prediction, and the band around the measured value in which it should lie.
struct MeasuredRow {
  std::string name, source, unit;
  double measured = 0, low = 0, high = 0;
  double predicted = 0;
};

inline bool is_inside(const MeasuredRow& row) {
  return row.predicted >= row.low && row.predicted <= row.high;
}

/// Row whose band is the measured value ± `half`.
inline MeasuredRow band_row(std::string name, std::string source, std::string unit, double measured,
                            double half, double predicted) {
  return {std::move(name), std::move(source), std::move(unit), measured,
          measured - half, measured + half,   predicted};
}

/// Measured points and the prediction at the same x, with the band's half width, as curves of a plot.
struct MeasuredCurve {
  std::string file, title, x_label, y_label;
  struct Point {
    double x, measured, half, predicted;
  };
  std::vector<Point> points;
};

/// Root mean square of predicted − measured, relative to the largest measured magnitude.
inline double relative_rms(const MeasuredCurve& curve) {
  double sum = 0, largest = 0;
  for (const auto& [x, measured, half, predicted] : curve.points) {
    sum += (predicted - measured) * (predicted - measured);
    largest = std::max(largest, std::abs(measured));
  }
  return std::sqrt(sum / double(curve.points.size())) / largest;
}

struct MeasuredResult {
  std::vector<MeasuredRow> rows;
  std::vector<MeasuredCurve> curves;
};

/// Laws of solids against closed forms of homogeneous deformations.
void add_laws(MeasuredResult& result);
/// Laws of the lattice at a point: confined compression, torsion, fibers, against closed forms.
void add_point_problems(MeasuredResult& result);
/// Laws in the elements of FEBio against the results that its test suite stores.
void add_febio(MeasuredResult& result);
/// Bodies of lattice cells against closed and published results. `quick`: without beams.
void add_body_problems(const Exec& exec, bool quick, MeasuredResult& result);
/// Muscle and skin: laws at a point of the material, fitted to some curves, predict others; skin also as a
/// sheet of a lattice body.
void add_muscle(MeasuredResult& result);
void add_skin_sheet(const Exec& exec, MeasuredResult& result);
/// Blocks of lattice cells with the exponential law and the pairs of the muscle's fit.
void add_muscle_bodies(const Exec& exec, MeasuredResult& result);
/// Brain: an Ogden law fitted to two of three tests predicts the third; a cube of lattice cells repeats them.
/// `quick`: without cubes.
void add_brain(const Exec& exec, bool quick, MeasuredResult& result);
/// Layered lattices under a flat probe; moduli fitted at two sites predict two others.
void add_limbs(const Exec& exec, MeasuredResult& result);
/// Disc cut out of tense skin on fat: tensions fitted to its specimen predict the wound. `quick`: larger
/// cells.
void add_disc(const Exec& exec, bool quick, MeasuredResult& result);
/// Bodies of the program: a strip of cloth under its weight, silicone bars of a lattice. `quick`: fewer.
void add_cantilever(const Exec& exec, bool quick, MeasuredResult& result);
void add_silicones(const Exec& exec, bool quick, MeasuredResult& result);

}  // namespace turgor
