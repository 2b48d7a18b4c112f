#pragma once
// The wheel of a body at the end of a step, and the way back from a wrench about its hub to the body's result.
#include "grouser/terrain/contact_patch.h"
#include "grouser/terrain/terrain.h"

namespace grouser {

struct WheelMotion {
  WheelPose pose;   ///< hub and spin axis
  Twist V;          ///< of the hub [W]
  Vec3 lever_W;     ///< body origin to hub [m]
  double spin = 0;  ///< w . axis [rad/s]
  Mat3 carrier;     ///< axes of frame C
};

/// @throws TerrainError when the spin axis is within 1e-6 of vertical: frame C is not defined there.
WheelMotion wheel_motion(const BodySpec& body, const BodyMotion& motion, double radius, double width);

/// Impulse, linearisation and the frame-C part of the report from the wrench about the hub. K and D as in Linearisation, about the hub.
void fill_result(const WheelMotion& wheel, const ContactPatch& patch, const Wrench& about_hub, const Mat6& K,
                 const Mat6& D, double dt, BodyResult& result);
/// Result of a wheel clear of the soil.
void clear_result(BodyResult& result);

/// Slip s = (r w - v)/max(|r w|, |v|), 0 when both are below `still` [m/s]; slip angle atan2(v_y, |v_x|), 0 when still.
struct Slip {
  double slip = 0, angle = 0;
};
Slip slip_of(double radius_times_spin, double v_forward, double v_lateral, double still = 1e-5);

}  // namespace grouser
