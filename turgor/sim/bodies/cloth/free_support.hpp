// Free bodies on cloth: rigid ones, and bodies of finite elements without fixed vertices. They move together
// with the cloth. A frame predicts the body's motion with the force of the cloth in earlier frames. The step
// of the cloth then solves for the motion of both (models/cloth/contact/free_obstacle.hpp), and the body is
// moved by what the impulse of the cloth differs from the predicted one. Momentum is exact. A body of finite
// elements moves as a whole by this difference; it deforms under the predicted force only.
#pragma once

#include <optional>
#include <vector>

#include "turgor/contact/coupling.hpp"
#include "turgor/models/cloth/model/state.hpp"
#include "turgor/sim/bodies/cloth/cloth_support.hpp"

namespace turgor {

struct ClothBody;

/// True if the steps of a cloth move this body: it is free, and the cloth uses conjugate gradients.
bool moves_with(const World& world, const ClothBody& cloth, BodyId body);

/// Positions of the support's vertices at the beginning of the frame [m].
std::vector<Vec3> positions_before(const World& world, const ClothSupport& support);
/// Largest speed of the support's vertices in this frame [m/s].
double largest_speed(const ClothSupport& support);
/// Inertia of the body in the step of the cloth, with the load that its prediction has.
cloth::FreeInertia free_inertia(const World& world, const ClothSupport& support);

/// Moves the body by the latest impulse of the cloth; `obstacle` is the index in its inputs. The force must
/// be recorded.
void move_support(const cloth::State& state, int obstacle, ClothSupport& support, World& world);
/// Relaxes the loads of all cloth on a free body, for the prediction of the next frame.
void relax_free_loads(World& world, BodyId body);

}  // namespace turgor
