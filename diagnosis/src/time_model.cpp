#include "time_model.h"

#include <algorithm>
#include <cmath>

namespace grouser::diagnosis {

namespace {

constexpr int shape_count = 4, drift_terms = 3, level_terms = 3;
constexpr double slip_step = 0.04, load_step = 0.1;  ///< change of slip, of ln load, from knot to knot

/// Legendre polynomials of degree 1 to 3 on -1..1.
double legendre(int degree, double x) {
  return degree == 1 ? x : degree == 2 ? 1.5 * x * x - 0.5 : 2.5 * x * x * x - 1.5 * x;
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

}  // namespace

int TimeAccount::effects() const { return static_cast<int>(std::count(on.begin(), on.end(), true)); }

std::string TimeAccount::id() const {
  std::string out;
  for (int e = 0; e < time_effect_count; ++e)
    if (on[static_cast<std::size_t>(e)])
      out += (out.empty() ? "" : "+") + std::string(time_effects()[static_cast<std::size_t>(e)].id);
  const char* more[] = {"", "response of another shape in time", "response of another shape over travel",
                        "drift with time", "steady level changes with slip"};
  if (extra == TimeExtra::none) return out.empty() ? "none" : out;
  return (out.empty() ? "" : out + " and ") + more[static_cast<int>(extra)];
}

TimeModel::TimeModel(const TimeCase& c, std::vector<TimeRun> runs, const std::array<bool, channel_count>& measured,
                     const std::array<bool, channel_count>& stated_sd)
    : case_(c), runs_(std::move(runs)), stated_(stated_sd) {
  for (int k = 0; k < channel_count; ++k)
    if (measured[static_cast<std::size_t>(k)]) channels_.push_back(k);
  for (int i = 0; i < soil_count; ++i)
    if (c.steady.soil[static_cast<std::size_t>(i)].sd > 0) soil_.push_back(i);
  for (int k = 0; k < 2; ++k)
    if (c.options.scatter[static_cast<std::size_t>(k)] > 0) scattered_.push_back(k);
  std::vector<double> spacings, speeds, durations;
  for (const TimeRun& r : runs_) {
    first_row_.push_back(row_count_);
    row_count_ += static_cast<int>(r.rows.size());
    TimeTrack track;
    track.spacing = r.spacing;
    first_knot_.push_back(static_cast<int>(knots_.size()));
    const auto speed_at = [&](std::size_t i) {
      return c.options.over == TimeOptions::Over::travel ? r.travel[i]
             : c.options.over == TimeOptions::Over::rim  ? r.rim[i]
                                                         : std::max(r.travel[i], r.rim[i]);
    };
    for (std::size_t i = 0; i < r.rows.size(); ++i) {
      track.rows.push_back(r.rows[i].time);
      if (speed_at(i) > 0) speeds.push_back(speed_at(i));
      // Moments before this row, then the row itself.
      const double moves = i == 0 ? 0
                                  : std::max(std::abs(r.rows[i].slip - r.rows[i - 1].slip) / slip_step,
                                             std::abs(std::log(r.rows[i].load / r.rows[i - 1].load)) / load_step);
      const int parts = std::clamp(static_cast<int>(std::ceil(moves)), 1, 24);
      for (int k = 1; k <= parts; ++k) {
        Run knot = r.rows[i];
        const double f = i == 0 ? 1 : k / static_cast<double>(parts);
        const std::size_t before = i == 0 ? 0 : i - 1;
        const auto mix = [&](double a, double b) { return (1 - f) * a + f * b; };
        if (k < parts) {
          knot.time = mix(r.rows[before].time, knot.time), knot.slip = mix(r.rows[before].slip, knot.slip);
          knot.load = mix(r.rows[before].load, knot.load), knot.omega = mix(r.rows[before].omega, knot.omega);
        }
        track.t.push_back(knot.time);
        track.speed.push_back(mix(speed_at(before), speed_at(i)));
        track.turn.push_back(mix(r.turn[before], r.turn[i]));
        knots_.push_back(std::move(knot));
      }
    }
    spacings.push_back(r.spacing);
    durations.push_back(track.t.back() - track.t.front());
    tracks_.push_back(std::move(track));
  }
  spacing_ = median(spacings), duration_ = median(durations);
  speed_ = speeds.empty() ? 1 : median(speeds);

  const int C = static_cast<int>(channels_.size());
  sd_.setConstant(row_count_, C, std::numeric_limits<double>::quiet_NaN());
  for (int k = 0; k < C; ++k) {
    const auto ch = static_cast<std::size_t>(channels_[static_cast<std::size_t>(k)]);
    // Where no error is stated: from differences of neighbours, which a slow wheel hardly moves.
    double guess = 0;
    if (!stated_[ch]) {
      std::vector<double> jumps;
      double largest = 0;
      for (const TimeRun& r : runs_)
        for (std::size_t i = 1; i < r.rows.size(); ++i) {
          const double jump = std::abs(r.rows[i].value[ch] - r.rows[i - 1].value[ch]);
          if (std::isfinite(jump)) jumps.push_back(jump), largest = std::max(largest, std::abs(r.rows[i].value[ch]));
        }
      if (!jumps.empty()) guess = std::max(median(jumps) / (0.6745 * std::sqrt(2.0)), 1e-4 * largest);
    }
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      double last = 0;
      bool first = true;
      for (std::size_t i = 0; i < runs_[r].rows.size(); ++i) {
        const Run& row = runs_[r].rows[i];
        if (!std::isfinite(row.value[ch])) continue;
        const int at = first_row_[r] + static_cast<int>(i);
        sd_(at, k) = stated_[ch] ? row.sd[ch] : guess;
        items_.push_back({static_cast<int>(r), at, k, sd_(at, k), first ? 0 : (row.time - last) / spacing_});
        last = row.time, first = false;
      }
    }
  }
  y_.resize(static_cast<Eigen::Index>(items_.size()));
  for (std::size_t i = 0; i < items_.size(); ++i)
    y_[static_cast<Eigen::Index>(i)] =
        runs_[static_cast<std::size_t>(items_[i].run)]
            .rows[static_cast<std::size_t>(items_[i].row - first_row_[static_cast<std::size_t>(items_[i].run)])]
            .value[static_cast<std::size_t>(channels_[static_cast<std::size_t>(items_[i].channel)])];
}

int TimeModel::extras(const TimeAccount& a) const {
  const int C = static_cast<int>(channels_.size());
  switch (a.extra) {
    case TimeExtra::shape_time:
    case TimeExtra::shape_travel:
      return shape_count;
    case TimeExtra::drift:
      return C * drift_terms;
    case TimeExtra::levels:
      return C * level_terms;
    case TimeExtra::none:
      break;
  }
  return 0;
}

namespace {
bool has_states(const TimeAccount& a) {
  return a.has(TimeEffect::relaxation_length) || a.has(TimeEffect::filter) || a.extra == TimeExtra::shape_time ||
         a.extra == TimeExtra::shape_travel;
}
}  // namespace

TimeModel::Layout TimeModel::layout(const TimeAccount& a) const {
  Layout l;
  const int C = static_cast<int>(channels_.size()), R = static_cast<int>(runs_.size());
  l.scatter = static_cast<int>(soil_.size());
  l.start = l.scatter + R * static_cast<int>(scattered_.size());
  l.dynamics = l.start + (case_.options.free_start && has_states(a) ? R * C : 0);
  l.extra = l.dynamics + (a.has(TimeEffect::relaxation_length) ? 1 : 0) + (a.has(TimeEffect::filter) ? 1 : 0) +
            (a.has(TimeEffect::delay) ? 1 : 0) + (a.has(TimeEffect::ripple) ? 2 * C : 0);
  l.size = l.extra + extras(a);
  return l;
}

int TimeModel::index_of(const TimeAccount& a, TimeEffect e) const {
  if (!a.has(e)) return -1;
  int at = layout(a).dynamics;
  for (const TimeEffect other : {TimeEffect::relaxation_length, TimeEffect::filter, TimeEffect::delay}) {
    if (other == e) return at;
    if (a.has(other)) ++at;
  }
  return at;
}

std::vector<TimeParameter> TimeModel::parameters(const TimeAccount& a) const {
  std::vector<TimeParameter> out;
  const int C = static_cast<int>(channels_.size());
  const double far = 1e300;
  for (const int i : soil_) {
    const SoilCoordinate& s = soil_coordinates()[static_cast<std::size_t>(i)];
    const SoilPrior& p = case_.steady.soil[static_cast<std::size_t>(i)];
    out.push_back({s.name, p.mean, p.sd, s.lower, s.upper});
  }
  for (std::size_t r = 0; r < runs_.size(); ++r)
    for (const int k : scattered_)
      out.push_back(
          {k == 0 ? "ln k of run" : "phi of run", 0, case_.options.scatter[static_cast<std::size_t>(k)], -far, far});
  std::vector<double> noise(static_cast<std::size_t>(C));
  for (int k = 0; k < C; ++k) {
    double sum = 0, n = 0;
    for (const Item& i : items_)
      if (i.channel == k) sum += i.sd, n += 1;
    noise[static_cast<std::size_t>(k)] = n > 0 ? sum / n : 1;
  }
  if (case_.options.free_start && has_states(a))
    for (std::size_t r = 0; r < runs_.size(); ++r)
      for (int k = 0; k < C; ++k) {
        double first = 0;
        for (const Run& row : runs_[r].rows) {
          const double v = row.value[static_cast<std::size_t>(channels_[static_cast<std::size_t>(k)])];
          if (!std::isfinite(v)) continue;
          first = v;
          break;
        }
        out.push_back({"start", first, 5 * noise[static_cast<std::size_t>(k)], -far, far});
      }
  // Time scales: log-normal between the spacing of the rows and a quarter of a run.
  const double low = std::log(spacing_), high = std::log(std::max(0.25 * duration_, 4 * spacing_));
  const double mean = 0.5 * (low + high), sd = (high - low) / 3, lower = low - std::log(30.0),
               upper = std::log(4 * duration_), travel = std::log(speed_);
  if (a.has(TimeEffect::relaxation_length))
    out.push_back({"relaxation_length", mean + travel, sd, lower + travel, upper + travel});
  if (a.has(TimeEffect::filter)) out.push_back({"filter", mean, sd, lower, upper});
  if (a.has(TimeEffect::delay)) out.push_back({"delay", mean, sd, lower, std::log(0.5 * duration_)});
  if (a.has(TimeEffect::ripple))
    for (int k = 0; k < C; ++k)
      for (int j = 0; j < 2; ++j) out.push_back({"ripple", 0, 10 * noise[static_cast<std::size_t>(k)], -far, far});
  const int extra = extras(a);
  for (int i = 0; i < extra; ++i) {
    const bool shape = a.extra == TimeExtra::shape_time || a.extra == TimeExtra::shape_travel;
    const int k = shape ? 0 : i / (a.extra == TimeExtra::drift ? drift_terms : level_terms);
    out.push_back({"free", 0, shape ? 1.0 : 10 * noise[static_cast<std::size_t>(k)], -far, far});
  }
  return out;
}

Eigen::VectorXd TimeModel::start(const TimeAccount& a) const {
  const std::vector<TimeParameter> p = parameters(a);
  Eigen::VectorXd x(static_cast<Eigen::Index>(p.size()));
  for (std::size_t i = 0; i < p.size(); ++i) x[static_cast<Eigen::Index>(i)] = p[i].mean;
  return x;
}

Eigen::VectorXd TimeModel::carried(const TimeAccount& from, const Eigen::VectorXd& x, const TimeAccount& to) const {
  Eigen::VectorXd out = start(to);
  const Layout f = layout(from), t = layout(to);
  out.head(t.start) = x.head(f.start);
  if (t.dynamics > t.start && f.dynamics > f.start)
    out.segment(t.start, t.dynamics - t.start) = x.segment(f.start, f.dynamics - f.start);
  for (int e = 0; e < time_effect_count; ++e) {
    const auto effect = static_cast<TimeEffect>(e);
    const int i = index_of(from, effect), j = index_of(to, effect);
    if (i < 0 || j < 0) continue;
    const int n = effect == TimeEffect::ripple ? 2 * static_cast<int>(channels_.size()) : 1;
    out.segment(j, n) = x.segment(i, n);
  }
  return out;
}

TimeDynamics TimeModel::dynamics(const TimeAccount& a, const Eigen::VectorXd& x) const {
  TimeDynamics d;
  const auto of = [&](TimeEffect e) {
    const int i = index_of(a, e);
    return i < 0 ? 0.0 : std::exp(x[i]);
  };
  d.sigma = of(TimeEffect::relaxation_length), d.tau = of(TimeEffect::filter), d.delay = of(TimeEffect::delay);
  if (a.has(TimeEffect::ripple)) {
    d.lugs = case_.options.lugs;
    const int i = index_of(a, TimeEffect::ripple);
    for (std::size_t k = 0; k < 2 * channels_.size(); ++k) d.ripple.push_back(x[i + static_cast<Eigen::Index>(k)]);
  }
  if (a.extra == TimeExtra::shape_time || a.extra == TimeExtra::shape_travel) {
    d.shape_over_travel = a.extra == TimeExtra::shape_travel;
    const double shortest = 2 * spacing_, longest = std::max(0.5 * duration_, 16 * spacing_);
    const Layout l = layout(a);
    for (int m = 0; m < shape_count; ++m) {
      const double time = shortest * std::pow(longest / shortest, m / (shape_count - 1.0));
      d.shape_scales.push_back(d.shape_over_travel ? time * speed_ : time);
      d.shape.push_back(x[l.extra + m]);
    }
  }
  return d;
}

bool TimeModel::targets(const Eigen::VectorXd& x, const Layout& l, bool slopes) const {
  const Eigen::VectorXd head = x.head(l.start);
  if (cached_soil_.size() == head.size() && cached_soil_ == head && (cached_slopes_ || !slopes))
    return !steady_.empty();
  std::array<double, soil_count> soil;
  for (std::size_t i = 0; i < soil_count; ++i) soil[i] = case_.steady.soil[i].mean;
  for (std::size_t i = 0; i < soil_.size(); ++i)
    soil[static_cast<std::size_t>(soil_[i])] = x[static_cast<Eigen::Index>(i)];
  Inputs plain = plain_inputs(soil);
  for (const KnownEffect& k : case_.steady.known)
    plain[static_cast<std::size_t>(input_of_effect(entry_of(k.id)))] = k.value;
  std::vector<Inputs> in(knots_.size(), plain);
  for (std::size_t r = 0; r < runs_.size(); ++r)
    for (std::size_t k = 0; k < scattered_.size(); ++k) {
      const double away = x[l.scatter + static_cast<Eigen::Index>(r * scattered_.size() + k)];
      const std::size_t coordinate = scattered_[k] == 0 ? 0 : 3;
      for (std::size_t i = 0; i < tracks_[r].t.size(); ++i)
        in[static_cast<std::size_t>(first_knot_[r]) + i][coordinate] += away;
    }
  cached_soil_ = head, cached_slopes_ = slopes;
  if (!model_runs(case_.steady.wheel, knots_, in, slopes ? Wanted::soil_and_touched : Wanted::value, {}, theta_,
                  steady_, slopes ? &steady_slopes_ : nullptr)) {
    steady_.clear();
    theta_.clear();
    return false;
  }
  return true;
}

bool TimeModel::predict(const TimeAccount& a, const Eigen::VectorXd& x, RowMatrix& y, Eigen::MatrixXd* slopes) const {
  const Layout l = layout(a);
  if (!targets(x, l, slopes != nullptr)) return false;
  const TimeDynamics d = dynamics(a, x);
  const int C = static_cast<int>(channels_.size()), S = static_cast<int>(soil_.size());
  const bool levels = a.extra == TimeExtra::levels, starts = l.dynamics > l.start;
  // Inputs of the track: soil coordinates that are free or scatter from run to run, then levels.
  std::vector<int> wanted = soil_;
  std::vector<int> scatter_at;
  for (const int k : scattered_) {
    const int coordinate = k == 0 ? 0 : 3;
    auto found = std::find(wanted.begin(), wanted.end(), coordinate);
    if (found == wanted.end()) wanted.push_back(coordinate), found = wanted.end() - 1;
    scatter_at.push_back(static_cast<int>(found - wanted.begin()));
  }
  const int W = static_cast<int>(wanted.size()), level_columns = levels ? C * level_terms : 0;
  y.resize(row_count_, C);
  if (slopes) slopes->setZero(row_count_ * C, l.size);
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    TimeTrack track = tracks_[r];
    track.channels = C;
    track.parameters = slopes ? W + level_columns : 0;
    const auto n = static_cast<Eigen::Index>(track.rows.size()), knots = static_cast<Eigen::Index>(track.t.size());
    track.target.setZero(knots, C * (1 + track.parameters));
    for (Eigen::Index i = 0; i < knots; ++i) {
      const auto at = static_cast<std::size_t>(first_knot_[r] + i);
      for (int k = 0; k < C; ++k) {
        const int ch = channels_[static_cast<std::size_t>(k)];
        track.target(i, k) = steady_[at][static_cast<std::size_t>(ch)];
        for (int p = 0; slopes && p < W; ++p)
          track.target(i, C * (1 + p) + k) = steady_slopes_[at](ch, wanted[static_cast<std::size_t>(p)]);
        for (int m = 0; levels && m < level_terms; ++m) {
          const double shape = legendre(m + 1, knots_[at].slip);
          track.target(i, k) += x[l.extra + k * level_terms + m] * shape;
          if (slopes) track.target(i, C * (1 + W + k * level_terms + m) + k) = shape;
        }
      }
    }
    std::vector<double> start;
    for (int k = 0; starts && k < C; ++k) start.push_back(x[l.start + static_cast<Eigen::Index>(r) * C + k]);
    TimeResponse out;
    if (!respond(track, d, start, slopes != nullptr, out)) return false;
    const double middle = 0.5 * (track.t.front() + track.t.back()), half = track.t.back() - middle;
    for (Eigen::Index i = 0; i < n; ++i)
      for (int k = 0; k < C; ++k) {
        const Eigen::Index row = (first_row_[r] + i);
        y(row, k) = out.y(i, k);
        const double when = (track.rows[static_cast<std::size_t>(i)] - middle) / half;
        for (int m = 0; a.extra == TimeExtra::drift && m < drift_terms; ++m) {
          y(row, k) += x[l.extra + k * drift_terms + m] * legendre(m + 1, when);
          if (slopes) (*slopes)(row * C + k, l.extra + k * drift_terms + m) = legendre(m + 1, when);
        }
        if (!slopes) continue;
        auto to = slopes->row(row * C + k);
        const auto from = out.slopes.row(i * C + k);
        to.head(S) = from.head(S);
        for (std::size_t q = 0; q < scattered_.size(); ++q)
          to[l.scatter + static_cast<Eigen::Index>(r * scattered_.size() + q)] = from[scatter_at[q]];
        if (levels) to.segment(l.extra, level_columns) = from.segment(W, level_columns);
        int at = W + level_columns;
        if (starts) to.segment(l.start + static_cast<Eigen::Index>(r) * C, C) = from.segment(at, C), at += C;
        to.segment(l.dynamics, l.extra - l.dynamics) = from.segment(at, l.extra - l.dynamics);
        at += l.extra - l.dynamics;
        if (!d.shape.empty()) to.segment(l.extra, shape_count) = from.segment(at, shape_count);
      }
  }
  return true;
}

Eigen::VectorXd TimeModel::item_values(const RowMatrix& y) const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(items_.size()));
  for (std::size_t i = 0; i < items_.size(); ++i)
    out[static_cast<Eigen::Index>(i)] = y(items_[i].row, items_[i].channel);
  return out;
}

}  // namespace grouser::diagnosis
