#include "turgor/models/cloth/build/scale_stiffness.hpp"

#include "turgor/core/assert.hpp"

namespace turgor::cloth {

void scale_stiffness(double factor, Model& model) {
  TURGOR_ASSERT(factor > 0, "a cloth is stiff");
  const Real f = Real(factor);
  for (aligned_vector<Real>* list : {&model.rows.stiffness, &model.rows.bend, &model.far_rows.stiffness,
                                     &model.far_rows.bend, &model.extra_diagonal})
    for (Real& k : *list) k *= f;
  MembraneLaw& law = model.membrane.law;
  for (Real* modulus : {&law.warp, &law.weft, &law.both, &law.shear}) *modulus *= f;
  Fabric& fabric = model.params.fabric;
  for (double* k : {&fabric.warp, &fabric.weft, &fabric.shear, &fabric.rigidity_warp, &fabric.rigidity_weft,
                    &fabric.bend})
    *k *= factor;
}

}  // namespace turgor::cloth
