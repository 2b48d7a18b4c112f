#include "told.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

namespace grouser::diagnosis {
namespace {

constexpr double seen = 4;         // sd of a mean from which a misfit is told
constexpr double stretched = 1.8;  // times the stated noise
constexpr double moved = 1.5;      // prior sd

std::string amount(std::size_t channel, double x, int digits = 3) {
  return short_number(x * (channel == 2 ? 1000 : 1), digits) +
         (channel == 2 ? " mm" : std::string(" ") + channel_names()[channel].unit);
}

/// The largest misfit of the refitted model in means over one slip, load, speed or pass.
std::string largest_misfit(const Diagnosis& d) {
  struct Axis {
    std::function<double(const Run&)> of;
    std::function<std::string(double)> says;
  };
  const Axis axes[] = {
      {[](const Run& r) { return std::round(r.slip * 50) / 50; },
       [](double x) { return "at slip " + short_number(x, 2); }},
      {[](const Run& r) { return r.load; }, [](double x) { return "at a load of " + short_number(x) + " N"; }},
      {[](const Run& r) { return r.omega; }, [](double x) { return "at " + short_number(x) + " rad/s"; }},
      {[](const Run& r) { return static_cast<double>(r.pass); },
       [](double x) { return "in pass " + short_number(x); }}};
  struct Mean {
    double n = 0, sum = 0, variance = 0;
  };
  double most = seen;
  std::string out;
  for (std::size_t ch = 0; ch < channel_count; ++ch)
    for (const Axis& axis : axes) {
      std::map<double, Mean> means;
      for (std::size_t i = 0; i < d.runs.size(); ++i) {
        if (!std::isfinite(d.runs[i].value[ch]) || d.weights[i] < 0.5) continue;
        Mean& m = means[axis.of(d.runs[i])];
        ++m.n, m.sum += d.runs[i].value[ch] - d.nominal.predicted[i][ch], m.variance += d.sd[i][ch] * d.sd[i][ch];
      }
      if (means.size() < 2) continue;
      for (const auto& [x, m] : means) {
        const double z = std::abs(m.sum) / std::sqrt(m.variance);
        if (z <= most) continue;
        most = z;
        out = std::string(soil_moved(d) ? "With its soil refitted the model's " : "The model's ") +
              std::string(channel_names()[ch].short_name) + " is " + amount(ch, std::abs(m.sum / m.n), 2) +
              (m.sum > 0 ? " too low " : " too high ") + axis.says(x) + " (" + short_number(z, 2) + " times the error" +
              (m.n > 1 ? " of the mean)" : ")");
      }
    }
  return out.empty() ? out : out + ". ";
}

std::string errors(const Diagnosis& d, const RunTable& data) {
  std::string out;
  const bool extended = d.verdict != "adequate" && d.verdict != "parameter", moves = soil_moved(d);
  for (std::size_t ch = 0; ch < channel_count; ++ch) {
    if (!data.measured[ch] || !std::isfinite(d.nominal.rmse[ch])) continue;
    out += out.empty() ? " Error of " : "; ";
    out += std::string(channel_names()[ch].short_name) + " ";
    if (d.stated && moves) out += amount(ch, d.stated->rmse[ch]) + ", ";
    out += amount(ch, d.nominal.rmse[ch]);
    if (extended) out += ", " + amount(ch, d.extended.rmse[ch]);
  }
  if (out.empty()) return out;
  out += " (";
  if (!moves) return out + (extended ? "as stated, extended)." : "as stated).");
  if (d.stated) out += "as stated, ";
  return out + (extended ? "refitted, extended)." : "refitted).");
}

std::string what_moved(const Diagnosis& d) {
  std::vector<std::string> list;
  for (const auto& [name, v] : d.nominal.parameters) {
    if (std::abs(v.prior_z) < moved) continue;
    list.push_back(name + " to " + short_number(v.value) + (v.unit == "1" ? "" : " " + v.unit) + " (" +
                   short_number(v.prior_z, 2) + " prior sd)");
  }
  return list.empty() ? "" : " The refit moved " + list_of(list, " and ") + ".";
}

std::string stretched_noise(const Diagnosis& d, const RunTable& data) {
  std::vector<std::string> list;
  for (std::size_t ch = 0; ch < channel_count; ++ch)
    if (data.measured[ch] && data.stated_sd[ch] && d.noise_scale[ch] > stretched)
      list.push_back(short_number(d.noise_scale[ch], 2) + " times what is stated for " +
                     channel_names()[ch].short_name);
  return list.empty() ? "" : " The noise would have to be " + list_of(list, " and ") + ".";
}

std::string contradictions(const Diagnosis& d) {
  std::vector<std::string> list;
  for (const RowStatics& r : d.statics)
    if (r.outside || r.slides) list.push_back(std::to_string(r.line));
  if (list.empty()) return "";
  return " By statics alone, whatever the soil, the channels of line" + std::string(list.size() > 1 ? "s " : " ") +
         list_of(list, " and ") + " contradict each other.";
}

std::string judged(const Diagnosis& d) {
  std::vector<std::string> list;
  for (const JudgedValue& j : d.judged)
    if (std::abs(j.z) > 3) list.push_back(j.name + " " + short_number(j.z, 2));
  if (d.judged.empty()) return "";
  return list.empty()
             ? " The soil to be judged lies within the priors."
             : " The soil to be judged is structural: it leaves the priors (" + list_of(list, " and ") + " prior sd).";
}

/// A gain is claimed where the interval leaves 1 out.
std::string gain_told(const Gain& g, const std::string& model) {
  const std::string of = " of that of the " + model + " model", ratio = short_number(g.rmse_ratio);
  std::string out = " On runs never used (" + list_of(g.withheld, " and ") + ") ";
  if (!g.carried) return out + "nothing is gained: what was found has no value where it was not seen.";
  if (g.has_interval) {
    const std::string interval = " [" + short_number(g.low) + ", " + short_number(g.high) + "]";
    if (g.high < 1) return out + "the error falls to " + ratio + of + interval + ".";
    if (g.low > 1) return out + "the error rises to " + ratio + " times" + of.substr(3) + interval + ".";
    return out + "no gain is shown: the error is " + ratio + of + interval + ".";
  }
  if (g.of_conditions.size() < 2)
    return out + "the error is " + ratio + of + ", on one condition: no interval can be given.";
  std::vector<std::string> each;
  for (const double x : g.of_conditions) each.push_back(short_number(x, 2));
  return out + "the error is " + ratio + of + " (" + list_of(each, " and ") + " on its " + std::to_string(each.size()) +
         " conditions, too few for an interval).";
}

}  // namespace

std::string list_of(const std::vector<std::string>& ids, const char* last) {
  std::string out;
  for (std::size_t i = 0; i < ids.size(); ++i) out += (i == 0 ? "" : i + 1 == ids.size() ? last : ", ") + ids[i];
  return out;
}

std::string short_number(double x, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, x);
  return text;
}

bool soil_moved(const Diagnosis& d) {
  return std::any_of(d.nominal.parameters.begin(), d.nominal.parameters.end(),
                     [](const auto& p) { return std::abs(p.second.prior_z) > 0.01; });
}

std::string told(const Diagnosis& d, const RunTable& data, const std::string& cause) {
  // Means over rows of one preparation scatter by more than their sensors do: where the model is adequate nothing is made of them.
  std::string out = (d.verdict == "adequate" ? "" : largest_misfit(d)) + cause + errors(d, data) + what_moved(d);
  if (d.gain) out += gain_told(*d.gain, soil_moved(d) ? "refitted" : "stated");
  return out + stretched_noise(d, data) + contradictions(d) + judged(d);
}

}  // namespace grouser::diagnosis
