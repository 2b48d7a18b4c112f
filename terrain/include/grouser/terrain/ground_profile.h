#pragma once
// Measured road profile: lines of heights along the road.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/ground_frame.h"

namespace grouser {

/// Heights of `lines` parallel lines at equal steps; z[line * n + i] [m] at s = i spacing, t = lateral_first + line
/// lateral_spacing.
struct ProfileData {
  int n = 0;                                      ///< samples per line, >= 2
  int lines = 0;                                  ///< >= 1; one line is constant across
  double spacing = 0;                             ///< [m] > 0
  double lateral_first = 0, lateral_spacing = 0;  ///< [m]; spacing > 0 when lines > 1
  std::vector<double> z;
};

/// CSV with one header row. Column 1 is the distance along the road, equally spaced and rising; each other column is
/// one line.
/// Lateral positions: header names that end in "v<number>" (m, e.g. z_mm_v-1.30), or lateral_first and lateral_spacing.
/// Lines from right to left or left to right.
struct ProfileFile {
  double length_unit = 1, height_unit = 1;               ///< [m] of column 1 and of the heights
  std::optional<double> lateral_first, lateral_spacing;  ///< [m]; override the header names
};
/// @throws ConfigError with line and column: ragged rows, a cell that is no finite number, a gap, an uneven or falling
/// coordinate, lateral positions unknown or uneven.
ProfileData read_profile_csv(const std::filesystem::path& file, const ProfileFile& settings);

/// h = offset + w(s) z(s, t), bilinear between samples (C0), w as in ground_sinusoid.h: over `run_in`, 0 before s = 0.
/// Without run_in the first sample continues
/// before s = 0. Beyond the end `outside` holds; beyond the outermost lines their heights continue (or error).
/// repeat: the data run once from the start as measured; over the last `seam` they are cross-faded (3u^2 - 2u^3) into
/// their own beginning, and so on with period length - seam.
struct ProfileSettings {
  enum class Detrend {
    none,
    mean,   ///< subtract the mean of all samples
    plane,  ///< subtract the least-squares plane a + b s + c t
  };
  Detrend detrend = Detrend::none;
  double offset = 0;  ///< [m] any
  double run_in = 0;  ///< [m] 0..length
  Outside outside = Outside::extend;
  double seam = 0;  ///< [m] repeat only: spacing <= seam <= length / 2
  GroundFrame frame;
};
/// @throws GroundError for settings outside these ranges. Cost: about 13 ns a point.
GroundPtr profile_ground(ProfileData data, const ProfileSettings& settings, std::string name);

}  // namespace grouser
