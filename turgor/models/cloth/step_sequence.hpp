// Order of the phases in a step, for a sheet on the host (step.cpp) and for one on a device
// (device_sheet.hpp). `Sheet` has a member function for each phase.
#pragma once

namespace turgor::cloth {

/// Motion of a step, after its linear system is solved: velocities, contact impulses, positions. False: the
/// state is not finite.
template <class Sheet>
bool move_sheet(Sheet& sheet) {
  sheet.change_velocities();
  sheet.limit_strain();
  sheet.measure_speed();
  sheet.solve_contact_impulses();
  if (!sheet.is_finite()) return false;
  sheet.move();
  sheet.solve_positions();
  return true;
}

/// End of a step: CCD. A state that is not finite is undone.
template <class Sheet>
void finish_step(Sheet& sheet, bool has_moved) {
  if (!has_moved) return sheet.undo();
  sheet.resolve_ccd();
  sheet.advance_time();
}

/// One step whose linear system is solved by sweeps of Jacobi's method.
template <class Sheet>
void step_sweeps(Sheet&& sheet) {
  sheet.predict();
  sheet.assemble();
  sheet.start_change();
  sheet.sweep();
  sheet.measure_residual();
  finish_step(sheet, move_sheet(sheet));
}

/// One step whose linear system is solved by conjugate gradients with implicit contacts. It is solved again
/// with the collisions of its motion as further contacts.
template <class Sheet>
void step_cg(Sheet&& sheet) {
  sheet.predict();
  bool has_moved;
  do {
    sheet.assemble();
    sheet.find_implicit_contacts();
    sheet.start_change();
    sheet.solve_with_implicit_contacts();
    sheet.relinearize();
    has_moved = move_sheet(sheet);
  } while (has_moved && sheet.rewinds_for_collisions());
  finish_step(sheet, has_moved);
}

}  // namespace turgor::cloth
