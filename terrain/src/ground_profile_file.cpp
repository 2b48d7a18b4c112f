#include <algorithm>
#include <cmath>

#include "ground_csv.h"
#include "ground_detail.h"
#include "grouser/terrain/ground_profile.h"

namespace grouser {

namespace {

using namespace ground_detail;

/// Number after the last 'v' of a column's name: z_mm_v-1.30 -> -1.30.
std::optional<double> lateral_of(const std::string& name) {
  const std::size_t v = name.rfind('v');
  return v == std::string::npos ? std::nullopt : parse_number(std::string_view(name).substr(v + 1));
}

/// Step of the coordinate; notes each place where it differs. Coordinates are text, so 1 % covers their rounding.
double even_step(const CsvTable& t, FileErrors& errors) {
  const auto columns = static_cast<std::size_t>(t.columns);
  auto u = [&](std::size_t row) { return t.cells[row * columns]; };
  std::vector<double> steps;
  for (std::size_t r = 1; r < static_cast<std::size_t>(t.rows); ++r) steps.push_back(u(r) - u(r - 1));
  std::vector<double> sorted = steps;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  if (!(usual > 0))
    errors.fail(t.line[1], 1, "the distance along the road (column 1) must rise from row to row; sort the rows by it");
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (std::abs(steps[i] - usual) <= 0.01 * usual) continue;
    const std::string between = number(u(i)) + " to " + number(u(i + 1));
    const std::string row = "row " + std::to_string(i + 2) + ": ";
    if (steps[i] <= 0)
      errors.add(t.line[i + 1], 1,
                 row + "the distance along the road does not rise (" + between +
                     "); sort the rows by it, and keep one row of each distance");
    else if (steps[i] > 1.5 * usual)
      errors.add(t.line[i + 1], 1,
                 row + "gap in the profile: the distance steps from " + between + " where the step is " +
                     number(usual) + "; fill the missing rows or split the file");
    else
      errors.add(t.line[i + 1], 1,
                 row + "the distance steps from " + between + " where the step is " + number(usual) +
                     "; a profile needs equal steps");
  }
  return (u(static_cast<std::size_t>(t.rows) - 1) - u(0)) / (t.rows - 1);
}

/// Lateral position of the first line and the spacing, which may be negative.
std::pair<double, double> laterals(const CsvTable& t, const ProfileFile& p, FileErrors& errors) {
  const int lines = t.columns - 1;
  if (p.lateral_first) return {*p.lateral_first, p.lateral_spacing.value_or(0)};
  if (lines == 1) return {0, 0};
  std::vector<double> v;
  for (std::size_t c = 1; c < t.header.size(); ++c) {
    const auto x = lateral_of(t.header[c]);
    if (!x)
      errors.add(t.header_line, t.header_columns[c],
                 "column '" + t.header[c] +
                     "' does not end in v<metres to the left> such as v-1.30; "
                     "rename it or give lateral_first and lateral_spacing");
    v.push_back(x.value_or(0));
  }
  errors.check();
  const double spacing = (v.back() - v.front()) / (lines - 1);
  for (std::size_t i = 1; i < v.size(); ++i)
    if (!(std::abs(v[i] - v[i - 1] - spacing) <= 0.01 * std::abs(spacing)) || spacing == 0)
      errors.add(t.header_line, t.header_columns[i + 1],
                 "the lines must be equally spaced across: '" + t.header[i + 1] + "' is " + number(v[i] - v[i - 1]) +
                     " m from its neighbour, the mean spacing is " + number(spacing) + " m");
  return {v.front(), spacing};
}

}  // namespace

ProfileData read_profile_csv(const std::filesystem::path& file, const ProfileFile& p) {
  const CsvTable t = read_csv(file, true, farthest / p.length_unit, farthest / p.height_unit);
  FileErrors errors(file);
  if (t.columns < 2)
    errors.fail(t.header_line, 1, "a profile needs the distance along the road and at least one column of heights");
  if (t.rows < 2) errors.fail(t.line[0], 1, "a profile needs at least two rows");
  if (p.lateral_first && t.columns > 2 && !p.lateral_spacing)
    errors.fail(t.header_line, 1, "lateral_first needs lateral_spacing for a profile of several lines");
  const double step = even_step(t, errors);
  const auto [first, spacing] = laterals(t, p, errors);
  errors.check();

  ProfileData d;
  d.n = t.rows;
  d.lines = t.columns - 1;
  d.spacing = step * p.length_unit;
  const bool reversed = spacing < 0;
  d.lateral_first = reversed ? first + (d.lines - 1) * spacing : first;
  d.lateral_spacing = std::abs(spacing);
  d.z.resize(static_cast<std::size_t>(d.n) * static_cast<std::size_t>(d.lines));
  for (int line = 0; line < d.lines; ++line) {
    const int column = reversed ? d.lines - line : line + 1;
    for (int i = 0; i < d.n; ++i)
      d.z[static_cast<std::size_t>(line) * static_cast<std::size_t>(d.n) + static_cast<std::size_t>(i)] =
          t.cells[static_cast<std::size_t>(i) * static_cast<std::size_t>(t.columns) +
                  static_cast<std::size_t>(column)] *
          p.height_unit;
  }
  return d;
}

}  // namespace grouser
