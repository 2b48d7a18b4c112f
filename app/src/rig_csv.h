#pragma once
#include <filesystem>

namespace grouser::app {

/// Beside the run.h5 of every case of a rig: series.csv with time, place, forces, sinkage and entry angle, SI, every recorded frame.
/// @throws ResultsError.
void write_rig_csv(const std::filesystem::path& folder);

}  // namespace grouser::app
