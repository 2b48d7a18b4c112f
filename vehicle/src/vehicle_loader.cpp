#include "grouser/vehicle/vehicle_loader.h"

#include <algorithm>
#include <tuple>

#include "vehicle_reader.h"

namespace grouser::vehicle {

void InputLog::take(const ConfigDocument& d) {
  errors.insert(errors.end(), d.diagnostics().begin(), d.diagnostics().end());
  assumptions.insert(assumptions.end(), d.assumptions().begin(), d.assumptions().end());
}

void InputLog::error(std::string file, int line, int column, std::string message) {
  errors.push_back({std::move(file), line, column, std::move(message)});
}

void InputLog::check() {
  if (errors.empty()) return;
  auto key = [](const Diagnostic& d) { return std::tie(d.file, d.line, d.column, d.message); };
  std::stable_sort(errors.begin(), errors.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  errors.erase(
      std::unique(errors.begin(), errors.end(), [&](const auto& a, const auto& b) { return key(a) == key(b); }),
      errors.end());
  throw ConfigError(errors);
}

VehicleSpec load_vehicle(const std::filesystem::path& file, const ConfigNode& extras, InputLog& log) {
  ReadVehicle v;
  v.spec.file = file.string();
  const std::size_t errors_before = log.errors.size();
  if (file.extension() == ".urdf") {
    for (const char* key : urdf_extras) extras.node(key);  // known here, also when the URDF itself cannot be read
    read_urdf_vehicle(file, extras, v, log);
  } else {
    for (const char* key : urdf_extras)
      if (extras.has(key)) {
        extras.node(key);
        extras.error_at(
            key, std::string("'") + key + "' belongs in the vehicle file; a scenario has it only for a URDF vehicle");
      }
    const ConfigDocument doc = ConfigDocument::from_file(file);
    if (doc.diagnostics().empty()) read_yaml_vehicle(doc.root(), v, log);
    log.take(doc);
  }
  if (log.errors.size() == errors_before) check_and_merge(v, log);
  return std::move(v.spec);
}

VehicleSpec load_urdf_alone(const std::filesystem::path& file, InputLog& log) {
  ReadVehicle v;
  v.spec.file = file.string();
  v.wheels_elsewhere = true;
  const std::size_t errors_before = log.errors.size();
  read_urdf_vehicle(file, {}, v, log);
  if (log.errors.size() == errors_before) check_and_merge(v, log);
  return std::move(v.spec);
}

}  // namespace grouser::vehicle
