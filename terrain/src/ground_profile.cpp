#include "grouser/terrain/ground_profile.h"

#include <algorithm>

#include "ground_bilinear.h"
#include "grouser/terrain/ground_extent.h"

namespace grouser {

namespace {

using namespace ground_detail;

/// Samples as a grid over (s, t); a single line is doubled, constant across.
HeightGrid grid_of(const ProfileData& d) {
  HeightGrid g{d.n, d.lines, 0, d.lateral_first, d.spacing, d.lateral_spacing, d.z};
  if (d.lines == 1) {
    g.ny = 2;
    g.dy = 1;
    g.z.insert(g.z.end(), d.z.begin(), d.z.end());
  }
  return g;
}

class ProfileGround final : public GroundShape<ProfileGround>, public GroundWithData {
 public:
  ProfileGround(const ProfileData& d, const ProfileSettings& p, std::string name)
      : p_(p),
        f_(p.frame),
        field_(grid_of(d)),
        lines_(d.lines),
        name_(std::move(name)),
        length_((d.n - 1) * d.spacing),
        cycle_(length_ - p.seam) {}

  double at(double x, double y) const {
    double s = f_.along(x, y);
    const double t = f_.across(x, y);
    if (p_.run_in > 0 && s <= 0) return p_.offset;
    if (p_.outside == Outside::error) check_inside(x, y, s, t);
    const double w = p_.run_in > 0 ? smooth(s / p_.run_in) : 1;
    if (p_.outside == Outside::repeat && s > cycle_) {
      s = std::fmod(s - cycle_, cycle_);
      if (s < p_.seam) {
        const double q = smooth(s / p_.seam);
        return p_.offset + w * ((1 - q) * sample(cycle_ + s, t) + q * sample(s, t));
      }
    } else if (p_.outside == Outside::mirror && s > length_) {
      mirror(s, length_);
    }
    return p_.offset + w * sample(s, t);
  }
  std::string beyond_data(double x, double y) const override {
    const double s = f_.along(x, y), t = f_.across(x, y);
    const double right = field_.grid.y0, left = right + (lines_ - 1) * field_.grid.dy;
    if (lines_ > 1 && !(p_.run_in > 0 && s <= 0) && (t < right || t > left))
      return "profile " + name_ + ": " + (t < right ? "right" : "left") +
             " of the outermost line, whose heights continue (data " + number(right) + ".." + number(left) +
             " m across)";
    if (s < 0 && p_.run_in == 0) return "profile " + name_ + ": before its start, where the first heights continue";
    if (s > length_ && p_.outside == Outside::extend)
      return "profile " + name_ + ": beyond its end at " + number(length_) + " m, where the last heights continue";
    return {};
  }
  double resolution() const override { return lines_ > 1 ? std::min(field_.grid.dx, field_.grid.dy) : field_.grid.dx; }
  std::string describe() const override {
    static const char* const beyond[] = {"end extended", "mirrored", "repeated", "error beyond"};
    std::string t = "profile " + name_ + ", " + std::to_string(field_.grid.nx) + " samples x " +
                    std::to_string(lines_) + (lines_ == 1 ? " line" : " lines") + ", " + number(length_) + " m, " +
                    beyond[static_cast<int>(p_.outside)];
    if (p_.run_in > 0) t += ", run-in " + number(p_.run_in) + " m";
    return t + frame_text(p_.frame);
  }

 private:
  double sample(double s, double t) const {
    Place p;
    field_.locate(field_.u(s), field_.v(t), p);
    return field_.height(p);
  }

  void check_inside(double x, double y, double s, double t) const {
    const double e = 1e-6 * field_.grid.dx;
    const double right = field_.grid.y0, left = right + (lines_ - 1) * field_.grid.dy;
    const bool across = lines_ == 1 || (t >= right - e && t <= left + e);
    if (s >= -e && s <= length_ + e && across) return;
    throw GroundError("profile " + name_ + ": the point (" + number(x) + ", " + number(y) + ") m lies at " + number(s) +
                      " m along and " + number(t) + " m across, outside 0.." + number(length_) + " m along" +
                      (lines_ > 1 ? ", " + number(right) + ".." + number(left) + " m across" : "") +
                      ", and 'outside' is error");
  }

  ProfileSettings p_;
  Frame f_;
  BilinearField field_;
  int lines_;
  std::string name_;
  double length_, cycle_;
};

/// On a full grid the coordinates are orthogonal once centred, so the plane's three coefficients are three separate
/// sums.
void detrend(ProfileData& d, ProfileSettings::Detrend how) {
  if (how == ProfileSettings::Detrend::none) return;
  const auto n = static_cast<std::size_t>(d.n), lines = static_cast<std::size_t>(d.lines);
  double mean = 0;
  for (double z : d.z) mean += z;
  mean /= static_cast<double>(d.z.size());
  double sz = 0, ss = 0, tz = 0, tt = 0;
  const double mid_i = 0.5 * (d.n - 1), mid_j = 0.5 * (d.lines - 1);
  for (std::size_t j = 0; j < lines; ++j)
    for (std::size_t i = 0; i < n; ++i) {
      const double s = static_cast<double>(i) - mid_i, t = static_cast<double>(j) - mid_j, z = d.z[j * n + i];
      sz += s * z, ss += s * s, tz += t * z, tt += t * t;
    }
  const bool plane = how == ProfileSettings::Detrend::plane;
  const double along = plane ? sz / ss : 0, across = plane && tt > 0 ? tz / tt : 0;
  for (std::size_t j = 0; j < lines; ++j)
    for (std::size_t i = 0; i < n; ++i)
      d.z[j * n + i] -= mean + along * (static_cast<double>(i) - mid_i) + across * (static_cast<double>(j) - mid_j);
}

}  // namespace

GroundPtr profile_ground(ProfileData d, const ProfileSettings& p, std::string name) {
  check_frame(p.frame);
  require(d.n >= 2 && d.lines >= 1, name + ": a profile needs at least 2 samples and 1 line");
  require(d.lines == 1 || d.lateral_spacing > 0, name + ": the spacing of the lines must be positive");
  check_grid(grid_of(d), name);
  const double length = (d.n - 1) * d.spacing;
  require(std::isfinite(p.offset), name + ": offset must be finite");
  require(p.run_in >= 0 && p.run_in <= length,
          name + ": run_in must be within 0.." + number(length) + " m, the profile's length");
  if (p.outside == Outside::repeat)
    require(p.seam >= d.spacing * (1 - 1e-9) && p.seam <= length / 2,
            name + ": outside: repeat needs a seam of " + number(d.spacing) + ".." + number(length / 2) +
                " m for a ground without a jump");
  else
    require(p.seam == 0, name + ": seam belongs to outside: repeat only");
  detrend(d, p.detrend);
  return std::make_shared<ProfileGround>(d, p, std::move(name));
}

}  // namespace grouser
