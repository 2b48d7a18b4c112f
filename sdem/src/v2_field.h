#pragma once
// `sdem.v2` with `rows`: wheels of a width, on soil that all of them share.
#include "grouser/sdem/field_wheel.h"

namespace grouser::sdem {

/// @throws TerrainError: no law, or a wheel of another radius than the law's.
void check_carries(const FieldSettings& o, const BodySpec& b);
std::unique_ptr<Terrain> make_v2_field(const FieldSettings& o, GroundPtr ground);

/// Energies of the last step [J] of wheels that hold `spent`, `integration` and `stored`: in the order of the bodies, whatever the threads did.
template <class Wheels>
void count_energies(const Wheels& wheels, EnergyLedger& ledger) {
  double stored = 0;
  for (const auto& w : wheels) {
    ledger.dissipated += w.spent;
    ledger.integration += w.integration;
    stored += w.stored;
  }
  ledger.stored = stored;
}

}  // namespace grouser::sdem
