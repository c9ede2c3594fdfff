// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "host/base/quiet_nan.hpp"
#include "host/study/scene_key.hpp"
#include "host/study/study_folder.hpp"

/// Runs that are over, on the disk: one file for each process that writes, to which records are
/// appended.
///
/// A file begins with 16 bytes: "ra2dlog", a line end, the format, and the low half of the XXH3-64
/// of these. A record is a head of 16 bytes, "run" and a line end, the length of its body, XXH3-64
/// of both; the body; and XXH3-128 of head and body. It is written by one call. A process that is
/// killed, or a power cut, leaves at the end a record that is not whole: it is ignored, and cut off
/// by the next process that writes to the file. Any other change is damage, and reported.
namespace ra2d {

/// How a run has ended. These are the numbers in the table.
enum class RunStatus : std::uint32_t {
  done = 0,
  missing = 1,  // in the table alone: it has not been run
  refused = 2,  // before its first step: the faces overlap, the step does not hold, ...
  failed = 3    // while it was marched: unstable, not finite, ...
};

/// The figures of a run as the ledger keeps them, named as in NoiseFigures and ResultSummary; NaN
/// where there is none. The scene alone makes all but the last.
struct RunFigures {
  double v_rms, lv;
  double shock_rate, shock_duration_median, peak_force_median;
  double contact_share, energy_closure;
  double wall_seconds;  // of its thread
  static constexpr std::size_t count = 8;
};
inline constexpr RunFigures no_figures{quiet_nan, quiet_nan, quiet_nan, quiet_nan,
                                       quiet_nan, quiet_nan, quiet_nan, quiet_nan};

/// Levels of a run's sound (host/analysis/sound_power.hpp); NaN where there is none.
struct SoundFigures {
  double lp = quiet_nan, lp_a = quiet_nan;  // dB re 20 uPa
  double lw = quiet_nan, lw_a = quiet_nan;  // dB re 1 pW
  static constexpr std::size_t count = 4;
};

struct FinishedRun {
  Key128 scene, run;  // scene_key; run_key, 0 where the run was refused before that is known
  RunStatus status = RunStatus::done;
  RunFigures figures = no_figures;
  std::string point;    // its name in the study that ran it
  std::string message;  // why it failed; of one that is done its warnings, a line each
  std::optional<SoundFigures> sound{};  // none where the study did not ask for it
  std::size_t folder = 0;               // of FinishedRuns::folders: where it was found
};

/// Whether two runs of one scene have come to the same, bit for bit, but for the time they took
/// and for their sound, which only one of them may have.
bool agree(const FinishedRun& a, const FinishedRun& b);

std::string ledger_head();
std::string record_of(const FinishedRun& run);
/// The record with this body, whatever it is.
std::string sealed_record(const std::string& body);

struct ParsedLedger {
  std::vector<FinishedRun> runs;  // in order
  std::size_t whole = 0;          // bytes up to the end of the last whole record
};
/// Gives `take` each run, in order; returns the bytes up to the end of the last whole record.
/// `file` is used in messages. Throws FileError that names the place of the damage.
std::size_t read_ledger(std::string_view bytes, const std::filesystem::path& file,
                        const std::function<void(FinishedRun)>& take);
/// Reads all runs at once.
ParsedLedger parse_ledger(std::string_view bytes, const std::filesystem::path& file);

/// One process's own.
class LedgerWriter {
 public:
  /// Makes or opens the file, takes it for this process alone, and cuts off what is not whole.
  /// Throws FileError, also where another process writes to it.
  explicit LedgerWriter(const std::filesystem::path& file);
  ~LedgerWriter();
  LedgerWriter(const LedgerWriter&) = delete;
  LedgerWriter& operator=(const LedgerWriter&) = delete;

  /// Appends a record. It outlives this process at once, and a power cut after the next sync().
  /// Threads may call both. Throws FileError; a record that could not be written whole is removed.
  void append(const FinishedRun& run);
  void sync();

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::size_t size_ = 0;
  std::mutex mutex_;
  bool synced_ = true;
};

/// The runs of all ledgers, by scene: one that is done rather than one that failed, of these one
/// that has its sound, else the latest.
struct FinishedRuns {
  std::unordered_map<Key128, FinishedRun> runs;
  std::vector<std::filesystem::path> folders;  // of the study, that have been added

  /// Adds those of a folder's ledgers. Throws FileError for damage, and for two runs of one scene
  /// with other numbers, which it names.
  void add(const StudyFolder& folder);
  void add(FinishedRun run, const std::filesystem::path& from);
  const FinishedRun* find(const Key128& scene) const;
};

}  // namespace ra2d
