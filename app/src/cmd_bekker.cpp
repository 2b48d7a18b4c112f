// grouser bekker forces, solve: the wheel's laws on files of cases.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "bekker_batch.h"
#include "commands.h"

namespace grouser::app {

namespace {

const std::map<std::string, bekker::Method> methods{{"nonlinear", bekker::Method::nonlinear},
                                                    {"quadratic", bekker::Method::quadratic},
                                                    {"linear", bekker::Method::linear}};

struct Arguments {
  BatchArguments batch;
  std::string method = "nonlinear";
  double tolerance = 0;
  bool free_slip = false;
};

// CLI::Range would print its limits with six decimals.
const CLI::Validator tolerance_range(
    [](const std::string& text) {
      const auto value = parse_number(text);
      const bool fits = value && *value >= 1e-13 && *value <= 1e-2;
      return fits ? std::string() : "'" + text + "' is not a number in the range 1e-13 to 0.01";
    },
    "1e-13..0.01");

constexpr const char* force_header = "Fx,Fy,Fz,Mx,My,Mz,status";

void run_forces(const Arguments& a) {
  const CaseFile cases(a.batch.cases, force_columns, optional_columns, {"Fx", "Fy", "Fz", "Mx", "My", "Mz", "status"});
  run_batch(a.batch, cases, force_header, [&](BatchBlock& block) {
    std::vector<bekker::ForceCase> in;
    for (std::size_t i = block.begin; i < block.end; ++i) {
      CaseFile::Row row(cases, i, block.errors);
      in.push_back(force_case(row));
    }
    if (block.check_only) return;
    std::vector<bekker::ForceResult> out(in.size());
    bekker::forces(in, methods.at(a.method), a.tolerance, out);
    for (const bekker::ForceResult& r : out) {
      const bekker::WheelWrench& w = r.wrench;
      block.add_row({w.Fx, w.Fy, w.Fz, w.Mx, w.My, w.Mz}, r.status);
    }
  });
}

void run_solve(const Arguments& a) {
  std::vector<CaseColumn> required = solve_columns;
  required.push_back(a.free_slip ? CaseColumn::torque_Nm : CaseColumn::slip);
  const std::string header =
      fmt::format("sinkage_m,theta_f_rad,theta_m_rad,theta_r_rad,drawbar_N,{},side_force_N,unloading_sinkage_m,status",
                  a.free_slip ? "slip" : "torque_Nm");
  std::vector<std::string> written{"sinkage_m", "theta_f_rad",  "theta_m_rad",         "theta_r_rad",
                                   "drawbar_N", "side_force_N", "unloading_sinkage_m", "status"};
  written.push_back(a.free_slip ? "slip" : "torque_Nm");
  const CaseFile cases(a.batch.cases, required, optional_columns, written);
  run_batch(a.batch, cases, header, [&](BatchBlock& block) {
    for (std::size_t i = block.begin; i < block.end; ++i) {
      CaseFile::Row row(cases, i, block.errors);
      const bekker::LoadCase c = load_case(row, a.free_slip);
      const double torque = a.free_slip ? row.number(CaseColumn::torque_Nm) : 0;
      if (block.check_only) continue;
      const bekker::Solution s = a.free_slip ? solve_free_slip(c, torque, methods.at(a.method), a.tolerance)
                                             : solve(c, methods.at(a.method), a.tolerance);
      block.add_row({s.sinkage, s.arc.theta_f, s.arc.theta_m, s.arc.theta_r, s.wrench.Fx,
                     a.free_slip ? s.slip : -s.wrench.My, s.wrench.Fy, s.unloading_sinkage},
                    s.status);
    }
  });
}

void add_options(CLI::App* cmd, const std::shared_ptr<Arguments>& a, double tolerance) {
  a->tolerance = tolerance;
  cmd->add_option("cases", a->batch.cases, "CSV file, columns as in bekker/README.md")->required();
  cmd->add_option("--method", a->method, "nonlinear (quadrature), quadratic or linear (closed forms)")
      ->check(CLI::IsMember({"nonlinear", "quadratic", "linear"}))
      ->capture_default_str();
  cmd->add_option("--tol", a->tolerance, "tolerance of the quadrature relative to the force")
      ->check(tolerance_range)
      ->capture_default_str();
  add_batch_options(cmd, a->batch);
}

}  // namespace

void add_bekker_command(CLI::App& cli, int& code) {
  auto* bekker = cli.add_subcommand("bekker", "Bekker-Wong wheel on files of cases: forces, load carried, tables");
  bekker->require_subcommand(1);
  const auto forces = std::make_shared<Arguments>(), solve = std::make_shared<Arguments>();
  auto* force_cmd = bekker->add_subcommand("forces", "six components of the force at given angles of contact");
  add_options(force_cmd, forces, 1e-6);
  force_cmd->callback([forces, &code] {
    run_forces(*forces);
    code = 0;
  });
  auto* solve_cmd = bekker->add_subcommand("solve", "sinkage, angles and forces of a wheel that carries a load");
  add_options(solve_cmd, solve, 1e-6);
  solve_cmd->add_flag("--free-slip", solve->free_slip, "column torque_Nm is given and the slip is found");
  solve_cmd->callback([solve, &code] {
    run_solve(*solve);
    code = 0;
  });
  add_bekker_table_command(*bekker, code);
}

}  // namespace grouser::app
