#pragma once
// One function per command; each returns the exit code. 0 done, 1 the simulation stopped, 2 the input is wrong.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace grouser::app {

struct RunArguments {
  std::filesystem::path scenario, out;
  std::optional<std::string> terrain;
  std::optional<std::string> duration;  ///< quantity with a unit, "5 s"
  int threads = 1;
  bool overwrite = false, no_report = false, quiet = false;
};
int run(const RunArguments& a);

struct RigArguments {
  std::filesystem::path rig, out;
  std::optional<std::string> terrain;
  std::string integrator = "fixed";
  std::vector<std::string> slips;  ///< numbers or percentages
  int threads = 1;
  bool overwrite = false, no_report = false, quiet = false, csv = false;
};
int rig(const RigArguments& a);

int resume(const std::filesystem::path& folder, int threads, bool quiet);
int check(const std::vector<std::filesystem::path>& files);
int list(const std::string& what, const std::string& id, bool yaml);
int report(const std::vector<std::filesystem::path>& folders, std::filesystem::path out);
int doctor();

/// Commands that define their own options; `code` becomes the exit code.
void add_plot_command(CLI::App& cli, int& code);
void add_fit_command(CLI::App& cli, int& code);       ///< with GROUSER_DIAGNOSIS only
void add_diagnose_command(CLI::App& cli, int& code);  ///< with GROUSER_DIAGNOSIS only
void add_bekker_command(CLI::App& cli, int& code);    ///< with GROUSER_BEKKER only
void add_soil_command(CLI::App& cli, int& code);      ///< with GROUSER_DEM only
void add_dem_command(CLI::App& cli, int& code);       ///< with GROUSER_DEM only
void add_sdem_command(CLI::App& cli, int& code);      ///< with GROUSER_SDEM only

/// Folder with soils/, wheels/, vehicles/, grounds/: $GROUSER_LIBRARY, else the installed one, else the source tree's examples/.
std::filesystem::path library_folder();

}  // namespace grouser::app
