#pragma once
// report.html: one file that opens from disk without a network: summary, 3-D playback and plots of one or several runs.
#include <filesystem>
#include <vector>

namespace grouser {

/// Write the report of one folder, or the comparison of several. A folder is what `grouser run` (run.h5) or `grouser
/// rig` (sweep.csv and case_*/run.h5, beside them errors.csv and measured.csv where there are any) left behind; both
/// kinds may be mixed.
///
/// Statistics and spectra come from every frame; the curves are thinned to at most 4000 values (least and greatest of
/// each bucket, so that no peak is lost), the poses to at most 60 per second. Values are quantised: 16 bits over the
/// range of each channel (error at most range/131068), positions 0.01 mm, time 1 us. About 1 MB for 20 s of a
/// four-wheel vehicle. A run that is still writing or that was stopped is reported as far as it came, and the page says
/// so.
///
/// @throws ResultsError: no folder given; a folder is missing or holds no results (names it and the remedy); the file
/// cannot be written.
void write_report(const std::vector<std::filesystem::path>& run_folders, const std::filesystem::path& html);

}  // namespace grouser
