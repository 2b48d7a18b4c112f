#pragma once
// One wheel of `sdem.v2` in three dimensions: rows across its width, each on the law in its own plane (direction_wheel.h), all on soil that
// belongs to the terrain (soil_field.h).
//
// Motion of row j at y_j along the axle, from that of the hub (v, w), forward f, axle a, z up:
//   ds = (v + w x y_j a) . f dt,  dz = (v + w x y_j a)_z dt,  dy = (v . a + r w . f) dt,  rim = r (w . a) dt            (F1)
// Force of a row: bearing times its width over that of the training times that of the law; its moment has the lever y_j a, and the
// side force, which acts at the soil, y_j a - r z. So the power of the wrench is that of the rows.
// Aside a wheel of width B meets new soil: per step the share dy(s)/(B/rows) of what each row stands in comes from the row beside it,
// for the first row from the field; dy(s) = dy + yaw times the place's distance from the hub.                               (F2)
#include <memory>
#include <vector>

#include "grouser/sdem/direction_wheel.h"
#include "grouser/sdem/soil_field.h"
#include "grouser/terrain/terrain.h"

namespace grouser::sdem {

struct FieldSettings {
  std::shared_ptr<const Direction> law;
  DirectionSettings wheel;
  int rows = 0;        ///< 0: a plane of its own for each wheel (v2)
  double cell = 8e-3;  ///< [m] of the field, and of the columns of a row
  double bearing = 1;  ///< force of a wheel of its width over that of as wide a part of an endless one
};

struct FieldForce {
  Wrench about_hub;  ///< [W]
  Mat6 K = Mat6::Zero(), D = Mat6::Zero();
  double normal = 0, entry = 0, exit = 0;
  double work = 0, spent = 0, stored = 0;  ///< [J]
  bool contact = false;
};

class FieldWheel {
 public:
  /// law: that of the settings with columns of `cell`.
  FieldWheel(const FieldSettings& s, std::shared_ptr<const Direction> law, double width, std::uint64_t seed);
  struct Motion {
    Vec3 begin, end;              ///< of the hub [m, W]
    Vec3 axis_begin, axis_end;    ///< along the axle
    Vec3 forward;                 ///< level, at the end
    double spin = 0, roll = 0, yaw = 0;  ///< w . axle, w . forward, w_z [rad/s]
    double dt = 0;
  };
  /// Cells that the wheel may read or change are those within this distance of the hub [m].
  double reach() const;
  /// Reads the field, and keeps what it moved for `change`.
  FieldForce step(const Motion& m, const SoilField& field);
  /// What the last step moved; then slopes slide.
  void change(SoilField& field);
  std::int64_t steps() const;
  std::int64_t outside() const;
  void traverse(State& s);

 private:
  struct Row {
    DirectionWheel plane;
    double y = 0;  ///< along the axle [m]
    double s = 0;  ///< hub along its way [m]
  };
  double around(double middle, const Vec3& hub, const Motion& m, double along, const SoilField& field, SoilField::Near& near) const;

  std::shared_ptr<const Direction> law_;
  double width_ = 0, strip_ = 0, scale_ = 0;
  int points_ = 1;  ///< across a row
  double way_ = 0;  ///< of the last step [m]
  std::vector<Row> rows_;
  std::vector<SoilField::Change> changes_;
  std::vector<Rut> before_;  ///< of the rows, at the beginning of the step
  std::vector<double> was_;  ///< heights of a row before its wheel
  SoilField::Footprint footprint_;
};

}  // namespace grouser::sdem
