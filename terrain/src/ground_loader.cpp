// Ground shapes from YAML; the schema is in examples/grounds/README.md.
#include <algorithm>
#include <map>

#include "ground_detail.h"
#include "grouser/terrain/ground_grid_files.h"
#include "grouser/terrain/ground_iso8608.h"
#include "grouser/terrain/ground_profile.h"
#include "grouser/terrain/ground_sinusoid.h"
#include "grouser/terrain/ground_slope.h"
#include "grouser/terrain/ground_step.h"
#include "grouser/terrain/ground_sum.h"
#include "grouser/terrain/loaders.h"

namespace grouser {

namespace {

// Far beyond any test ground: what lies outside is a wrong unit or exponent.
constexpr Range place{-1e6, 1e6, false, false};       // [m]
constexpr Range reach{0, 1e6, false, false};          // [m]
constexpr Range length{1e-6, 1e6, false, false};      // [m]
constexpr Range per_length{1e-9, 1e6, false, false};  // [1/m]

const std::map<std::string, Outside> outside_names = {
    {"extend", Outside::extend}, {"mirror", Outside::mirror}, {"repeat", Outside::repeat}, {"error", Outside::error}};

/// Read the settings, report unknown keys, and build only when nothing was refused.
template <class Read, class Build>
GroundPtr checked(const ConfigNode& n, Read read, Build build) {
  const std::size_t before = n.errors();
  const auto settings = read();
  n.finish();
  if (n.errors() != before) return flat_ground();
  try {
    return build(settings);
  } catch (const GroundError& e) {
    n.error(e.what());
  } catch (const ConfigError& e) {
    for (const Diagnostic& d : e.diagnostics()) n.report(d);
  }
  return flat_ground();
}

GroundFrame read_frame(const ConfigNode& n, bool with_lateral) {
  GroundFrame f;
  f.heading = n.quantity_or("heading", 0, "deg", Range::between(-pi, pi));
  f.start = n.quantity_or("start", 0, "m", place);
  if (with_lateral) f.lateral = n.quantity_or("lateral", 0, "m", place);
  return f;
}

GroundPtr read_flat(const ConfigNode& n) {
  return checked(
      n, [&] { return n.quantity_or("height", 0, "m", place); }, [](double z) { return flat_ground(z); });
}

GroundPtr read_slope(const ConfigNode& n) {
  return checked(
      n,
      [&] {
        SlopeSettings p;
        p.angle = n.quantity("angle", "deg", Range::between(-pi / 3, pi / 3));
        p.transition = n.quantity_or("transition", 0, "m", reach);
        p.frame = read_frame(n, false);
        return p;
      },
      slope_ground);
}

GroundPtr read_step(const ConfigNode& n) {
  return checked(
      n,
      [&] {
        StepSettings p;
        p.height = n.quantity("height", "m", place);
        p.ramp = n.quantity_or("ramp", 0, "m", reach);
        p.frame = read_frame(n, false);
        return p;
      },
      step_ground);
}

GroundPtr read_sinusoid(const ConfigNode& n) {
  return checked(
      n,
      [&] {
        SinusoidSettings p;
        p.amplitude = n.quantity("amplitude", "mm", Range::between(0, 1e3));
        const bool by_period = n.has("period"), by_wavenumber = n.has("wavenumber");
        if (by_period == by_wavenumber)
          n.error(by_period ? "'period' and 'wavenumber' are both given; one of them says it all"
                            : "give 'period' (for example 195 mm) or 'wavenumber' (for example 32.2 rad/m)");
        if (by_period) p.wavenumber = 2 * pi / n.quantity("period", "mm", length);
        if (by_wavenumber) p.wavenumber = n.quantity("wavenumber", "rad/m", per_length);
        p.phase = n.quantity_or("phase", 0, "deg", Range::between(-100, 100));
        p.run_in = n.quantity_or("run_in", 0, "m", reach);
        p.bounded_start = n.has("start");
        p.frame = read_frame(n, false);
        if (const auto end = n.optional_quantity("end", "m", place)) {
          p.length = *end - p.frame.start;
          if (!(p.length > 0))
            n.error_at("end", "must lie beyond the start at " + ground_detail::number(p.frame.start) + " m");
        }
        return p;
      },
      sinusoid_ground);
}

GroundPtr read_iso8608(const ConfigNode& n, std::uint64_t seed) {
  return checked(
      n,
      [&] {
        using Coherence = Iso8608Settings::Coherence;
        Iso8608Settings p;
        const bool by_class = n.has("class"), by_roughness = n.has("roughness");
        if (by_class == by_roughness)
          n.error(by_class ? "'class' and 'roughness' are both given; one of them says it all"
                           : "give 'class' (A..H) or 'roughness' (Gd at 0.1 cycle/m, for example 4096e-6 m^3)");
        if (by_class) p.roughness = iso8608_roughness(n.choice("class", {"A", "B", "C", "D", "E", "F", "G", "H"})[0]);
        if (by_roughness) p.roughness = n.quantity("roughness", "m^3", {0, 1e3, true, false});
        p.waviness = n.quantity_or("waviness", p.waviness, "1", Range::between(1, 4));
        // In SI a spatial frequency is in rad/m; the standard's is in cycles/m.
        if (const auto k = n.optional_quantity("lowest", "cycle/m", per_length)) p.lowest = *k / (2 * pi);
        if (const auto k = n.optional_quantity("highest", "cycle/m", per_length)) p.highest = *k / (2 * pi);
        const std::string coherence = n.choice_or("coherence", "isotropic", {"isotropic", "exponential", "full"});
        p.coherence = coherence == "full"          ? Coherence::full
                      : coherence == "exponential" ? Coherence::exponential
                                                   : Coherence::isotropic;
        if (p.coherence == Coherence::full)
          p.track_width = n.quantity_or("track_width", 1, "m", length);
        else
          p.track_width = n.quantity("track_width", "m", length);
        if (p.coherence == Coherence::exponential)
          p.decay = n.quantity("decay", "1", Range::between(0, 1e6));
        else if (n.has("decay"))
          n.error_at("decay", "belongs to 'coherence: exponential'");
        p.period = n.quantity_or("period", p.period, "m", length);
        p.run_in = n.quantity_or("run_in", 0, "m", reach);
        p.frame = read_frame(n, true);
        p.seed =
            n.has("seed") ? static_cast<std::uint64_t>(n.integer("seed", 0, std::numeric_limits<long>::max())) : seed;
        return p;
      },
      iso8608_ground);
}

/// Unit of a column of a data file, in SI.
double read_length_unit(const ConfigNode& n, const std::string& key) {
  return parse_unit(n.choice(key, {"m", "cm", "mm", "um", "in", "ft"})).scale;
}

std::string lower_extension(const std::filesystem::path& file) {
  std::string e = file.extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return e;
}

struct HeightMapSettings {
  std::filesystem::path file;
  std::string format;
  double spacing = 0, height_unit = 1, offset = 0;
  std::vector<double> range, lower_left;
  Outside outside = Outside::extend;
};

HeightMapSettings read_height_map_settings(const ConfigNode& n) {
  HeightMapSettings p;
  p.file = n.existing_file("file");
  const std::string e = lower_extension(p.file);
  p.format = e == ".png" ? "png" : e == ".asc" ? "esri" : e == ".csv" ? "csv" : "";
  if (n.has("format"))
    p.format = n.choice("format", {"png", "esri", "csv"});
  else if (p.format.empty() && std::filesystem::is_regular_file(p.file))
    n.error_at("file",
               "the format is not clear from '" + p.file.filename().string() + "'; add 'format: png', 'esri' or 'csv'");
  // A key of another format is an unknown key here.
  if (p.format == "png" || p.format == "csv") p.spacing = n.quantity("spacing", "m", length);
  if (p.format == "png" && !n.has("height_range")) {
    n.node("height_range");
    n.error("missing key 'height_range', the heights of black and white; for example 'height_range: [0 m, 1 m]'");
  } else if (p.format == "png") {
    p.range = n.quantities("height_range", "m", 2, place);
  }
  if (p.format == "csv") p.height_unit = read_length_unit(n, "height_unit");
  if (p.format == "esri" && n.has("height_unit")) p.height_unit = read_length_unit(n, "height_unit");
  if (n.has("lower_left")) p.lower_left = n.quantities("lower_left", "m", 2);
  p.offset = n.quantity_or("offset", 0, "m", place);
  p.outside = outside_names.at(n.choice_or("outside", "extend", {"extend", "mirror", "error"}));
  if (p.range.size() == 2 && !(p.range[0] < p.range[1]))
    n.error_at("height_range", "the first height (black) must be below the second (white)");
  return p;
}

GroundPtr build_height_map(const HeightMapSettings& p) {
  HeightGrid g = p.format == "png"    ? read_height_png(p.file, p.spacing, p.range[0], p.range[1])
                 : p.format == "esri" ? read_height_esri(p.file, p.height_unit)
                                      : read_height_csv(p.file, p.spacing, p.height_unit);
  if (!p.lower_left.empty()) {
    g.x0 = p.lower_left[0];
    g.y0 = p.lower_left[1];
  }
  for (double& z : g.z) z += p.offset;
  return height_map_ground(std::move(g), p.outside, p.file.filename().string());
}

struct ProfileRequest {
  std::filesystem::path file;
  ProfileFile columns;
  ProfileSettings settings;
};

ProfileRequest read_profile_request(const ConfigNode& n) {
  ProfileRequest p;
  p.file = n.existing_file("file");
  p.columns.length_unit = read_length_unit(n, "length_unit");
  p.columns.height_unit = read_length_unit(n, "height_unit");
  p.columns.lateral_first = n.optional_quantity("lateral_first", "m", place);
  p.columns.lateral_spacing = n.optional_quantity("lateral_spacing", "m", place);
  if (p.columns.lateral_spacing && !p.columns.lateral_first)
    n.error_at("lateral_spacing", "needs 'lateral_first' next to it");
  if (p.columns.lateral_spacing == 0.0)
    n.error_at("lateral_spacing", "must not be 0; negative means from left to right");
  const std::string detrend = n.choice_or("detrend", "none", {"none", "mean", "plane"});
  p.settings.detrend = detrend == "plane"  ? ProfileSettings::Detrend::plane
                       : detrend == "mean" ? ProfileSettings::Detrend::mean
                                           : ProfileSettings::Detrend::none;
  p.settings.offset = n.quantity_or("offset", 0, "m", place);
  p.settings.run_in = n.quantity_or("run_in", 0, "m", reach);
  p.settings.outside = outside_names.at(n.choice_or("outside", "extend", {"extend", "mirror", "repeat", "error"}));
  if (p.settings.outside == Outside::repeat)
    p.settings.seam = n.quantity("seam", "m", length);
  else if (n.has("seam"))
    n.error_at("seam", "belongs to 'outside: repeat'");
  p.settings.frame = read_frame(n, true);
  return p;
}

GroundPtr build_profile(const ProfileRequest& p) {
  return profile_ground(read_profile_csv(p.file, p.columns), p.settings, p.file.filename().string());
}

GroundPtr load_at_depth(const ConfigNode& node, std::uint64_t seed, int depth);

GroundPtr read_document(const ConfigDocument& doc, std::uint64_t seed, int depth) {
  const ConfigNode root = doc.root();
  if (!root.present()) return flat_ground();
  GroundPtr g = flat_ground();
  if (root.has("ground"))
    g = load_at_depth(root.node("ground"), seed, depth);
  else
    root.error("a ground file needs 'ground:' with a shape or a list of shapes");
  root.text_or("source", "");
  root.finish();
  return g;
}

GroundPtr read_include(const ConfigNode& n, std::uint64_t seed, int depth) {
  const std::size_t before = n.errors();
  const std::filesystem::path file = n.existing_file("include");
  n.finish();
  if (n.errors() != before) return flat_ground();
  if (depth >= 8) {
    n.error_at("include", "grounds include each other more than 8 deep");
    return flat_ground();
  }
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const GroundPtr g = read_document(doc, seed, depth + 1);
  for (const Diagnostic& d : doc.diagnostics()) n.report(d);
  for (const Assumption& a : doc.assumptions()) n.assume(a.key, a.value, a.why);
  return g;
}

GroundPtr read_shape(const ConfigNode& n, std::uint64_t seed, int depth) {
  static const std::vector<std::string> shapes = {"flat",    "slope",      "step",   "sinusoid",
                                                  "iso8608", "height_map", "profile"};
  if (!n.is_map()) {
    n.error("a ground shape is a map such as {shape: flat}, or {include: file.yaml}");
    return flat_ground();
  }
  if (n.has("include") && !n.has("shape")) return read_include(n, seed, depth);
  const std::size_t before = n.errors();
  const std::string shape = n.choice("shape", shapes);
  if (n.errors() != before) return flat_ground();
  if (shape == "flat") return read_flat(n);
  if (shape == "slope") return read_slope(n);
  if (shape == "step") return read_step(n);
  if (shape == "sinusoid") return read_sinusoid(n);
  if (shape == "iso8608") return read_iso8608(n, seed);
  if (shape == "height_map")
    return checked(
        n, [&] { return read_height_map_settings(n); }, build_height_map);
  return checked(
      n, [&] { return read_profile_request(n); }, build_profile);
}

/// Two random shapes of one list must not be the same shape twice. SplitMix64 of the seed, stepped by the place in the
/// list.
std::uint64_t seed_of_item(std::uint64_t seed, std::size_t i) {
  if (i == 0) return seed;
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ull * i;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

GroundPtr load_at_depth(const ConfigNode& node, std::uint64_t seed, int depth) {
  if (!node.present()) return flat_ground();
  if (!node.is_list()) return read_shape(node, seed, depth);
  const std::vector<ConfigNode> items = node.items();
  if (items.empty()) {
    node.error("the list of ground shapes is empty; for level ground write {shape: flat}");
    return flat_ground();
  }
  std::vector<GroundPtr> parts;
  for (std::size_t i = 0; i < items.size(); ++i) parts.push_back(read_shape(items[i], seed_of_item(seed, i), depth));
  return sum_ground(std::move(parts));
}

}  // namespace

GroundPtr load_ground(const ConfigNode& node, std::uint64_t seed) { return load_at_depth(node, seed, 0); }

GroundPtr load_ground_file(const std::filesystem::path& file, std::uint64_t seed) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const GroundPtr g = read_document(doc, seed, 0);
  doc.check();
  return g;
}

}  // namespace grouser
