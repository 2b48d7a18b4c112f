#pragma once
// Ranges that several readers share. The upper ends lie far beyond any vehicle: what exceeds them is a wrong unit or exponent.
#include "grouser/terrain/config.h"

namespace grouser::vehicle::ranges {

inline constexpr Range duration{0, 1e6, true, false};     // [s]
inline constexpr Range pause{0, 1e6, false, false};       // [s]
inline constexpr Range gravity{0, 1000, true, false};     // [m/s^2]
inline constexpr Range place{-1e6, 1e6, false, false};    // [m] on the ground
inline constexpr Range offset{-1e3, 1e3, false, false};   // [m] within a vehicle
inline constexpr Range size{0, 1e3, true, false};         // [m]
inline constexpr Range mass{0, 1e6, true, false};         // [kg]
inline constexpr Range inertia{-1e9, 1e9, false, false};  // [kg m^2]
inline constexpr Range load{0, 1e7, true, false};         // [N]
inline constexpr Range speed{-100, 100, false, false};    // [m/s]
inline constexpr Range spin{-1e4, 1e4, false, false};     // [rad/s]
inline constexpr Range rate{1e-3, 1e6, false, false};     // [1/s] of output
inline constexpr Range positive{0, 1e12, true, false};    // stiffness, torque, gain, capacity
inline constexpr Range non_negative{0, 1e12, false, false};
inline constexpr Range any{-1e12, 1e12, false, false};

}  // namespace grouser::vehicle::ranges
