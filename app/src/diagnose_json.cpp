#include "diagnose_json.h"

#include <cmath>

namespace grouser::app {

namespace {

using Json = nlohmann::ordered_json;
using namespace diagnosis;

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }
Json text(const std::string& s) { return s.empty() ? Json(nullptr) : Json(s); }

Json by_channel(const std::array<double, channel_count>& values) {
  Json out = Json::object();
  for (std::size_t c = 0; c < channel_count; ++c)
    if (std::isfinite(values[c])) out[channel_names()[c].column] = values[c];
  return out;
}

Json interval(const Interval& i) {
  return {{"value", number(i.value)},
          {"sd", number(i.sd)},
          {"ci90", {number(i.low), number(i.high)}},
          {"unit", i.unit},
          {"times_typical", number(i.times_typical)}};
}

Json model(const FittedModel& m) {
  Json parameters = Json::object();
  for (const auto& [name, v] : m.parameters)
    parameters[name] = {{"value", number(v.value)},
                        {"sd", number(v.sd)},
                        {"prior_z", number(v.prior_z)},
                        {"sd_over_prior", number(v.sd_over_prior)},
                        {"unit", v.unit}};
  return {{"rmse", by_channel(m.rmse)}, {"chi2", number(m.chi2)}, {"dof", m.dof}, {"parameters", parameters}};
}

Json tests(const std::vector<FitTest>& list) {
  Json out = Json::array();
  for (const FitTest& t : list)
    out.push_back({{"test", t.test},
                   {"about", text(t.about)},
                   {"statistic", number(t.statistic)},
                   {"p", t.p},
                   {"p_holm", t.holm}});
  return out;
}

}  // namespace

Json diagnosis_json(const Diagnosis& d) {
  Json j;
  j["verdict"] = d.verdict;
  j["cause"] = text(d.cause);
  j["class"] = d.members;
  j["sentence"] = d.sentence;
  j["posterior"] = d.posterior;
  j["parameters"] = Json::object();
  for (const auto& [id, i] : d.parameters) j["parameters"][id] = interval(i);
  j["unknown"] = {
      {"variable", text(d.unknown_variable)}, {"acts_through", text(d.unknown_through)}, {"curve", d.unknown_curve}};
  j["stated"] = d.stated ? Json{{"rmse", by_channel(d.stated->rmse)}, {"chi2", number(d.stated->chi2)}} : Json(nullptr);
  j["nominal"] = model(d.nominal);
  j["extended"] = model(d.extended);
  j["lack_of_fit"] = {{"nominal", tests(d.nominal.tests)}, {"extended", tests(d.extended.tests)}};
  if (d.gain)
    j["gain"] = {{"withheld", d.gain->withheld},
                 {"runs", d.gain->runs},
                 {"rmse_ratio", d.gain->rmse_ratio},
                 {"ci95", d.gain->has_interval ? Json{d.gain->low, d.gain->high} : Json(nullptr)},
                 {"rmse_ratio_of_conditions", d.gain->of_conditions},
                 {"nominal_rmse", by_channel(d.gain->nominal_rmse)},
                 {"extended_rmse", by_channel(d.gain->extended_rmse)}};
  else
    j["gain"] = nullptr;
  j["next_experiment"] = Json::array();
  for (const NextExperiment& e : d.next) {
    Json x{{"condition", e.condition}, {"decides", e.decides}, {"chance", e.chance}, {"cost_runs", e.cost}};
    if (e.simulated) x["chance_simulated"] = *e.simulated;
    if (e.runs > 0) x["runs"] = e.runs;
    if (!e.bench_check.empty()) x["bench_check"] = e.bench_check, x["bench_effect"] = e.bench_effect;
    j["next_experiment"].push_back(x);
  }
  j["refit_needed"] = Json::array();
  for (const Needed& n : d.needed)
    j["refit_needed"].push_back(
        {{"held", n.held}, {"chi2_rise", n.rise}, {"prior_z", n.prior_z}, {"rmse", by_channel(n.rmse)}});
  j["judged"] = Json::array();
  for (const JudgedValue& v : d.judged)
    j["judged"].push_back({{"name", v.name},
                           {"value", v.value},
                           {"prior", v.prior},
                           {"unit", v.unit},
                           {"z", v.z},
                           {"structural", std::abs(v.z) > 3}});
  j["statics"] = Json::array();
  for (const RowStatics& r : d.statics)
    j["statics"].push_back({{"line", r.line},
                            {"slip", r.slip},
                            {"load_N", r.load},
                            {"theta_rad", r.theta},
                            {"theta_f_rad", r.theta_f},
                            {"theta_sd_rad", r.theta_sd},
                            {"friction", r.friction},
                            {"friction_sd", r.friction_sd},
                            {"contradicts", r.outside || r.slides}});
  j["suspect_rows"] = d.suspect_lines;
  j["noise"] = {{"sensor_scale", by_channel(d.noise_scale)},
                {"scatter_ln_k", d.scatter_ln_k},
                {"scatter_phi_rad", d.scatter_phi}};
  j["ranking"] = Json::array();
  for (const Ranked& r : d.ranking) {
    Json x{{"id", r.id},
           {"log_likelihood_gain", r.log_likelihood},
           {"log_evidence", r.log_evidence},
           {"posterior", r.posterior},
           {"cross_validation_gain", number(r.cross_validation)},
           {"refitted", r.refitted}};
    for (const Interval& i : r.amplitudes) x["amplitudes"].push_back(interval(i));
    j["ranking"].push_back(x);
  }
  j["notes"] = d.notes;
  j["timing"] = {{"rank_s", d.rank_seconds}, {"total_s", d.total_seconds}};
  return j;
}

}  // namespace grouser::app
