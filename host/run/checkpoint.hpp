// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/device/saved_state.hpp"
#include "host/model/model.hpp"
#include "host/run/run_watch.hpp"
#include "host/run/simulation.hpp"
#include "host/store/output_names.hpp"
#include "host/store/recording.hpp"

/// Checkpoints: a run that was cut off goes on from one.
namespace ra2d {

/// The program that wrote a checkpoint, and the run that it belongs to.
struct Identity {
  std::string program;     // version and commit
  std::string arithmetic;  // of the build (arithmetic())
  std::string backend;     // where it was marched
  std::string key;         // run_key
  std::string scene;       // TOML text
};

struct Checkpoint {
  Identity identity;
  SavedState state;
  Accounts accounts;
  RunWatch::Seen seen;            // of a run that keeps its outputs
  double wall_seconds = 0;        // of the run until then
  std::vector<Segment> segments;  // of its outputs, all that it covers
};

/// The run that this program is about to make.
Identity identity_of(const std::string& key, const std::string& scene);

/// As it stands in a file, and back. Throws CorruptFile (host/store/sealed_file.hpp) where a byte
/// is not as it was. A state that does not fit its scene is found when it is gone on from
/// (Batch::restore).
std::string bytes_of(const Checkpoint& checkpoint);
Checkpoint checkpoint_of(const std::string& bytes);

/// Throws CorruptFile, and FileError where the file cannot be read.
Checkpoint read_checkpoint(const std::filesystem::path& file);

/// Whether what a run records is kept, and so has to be there for it to go on.
enum class Outputs { kept, not_kept };

/// The difference between a checkpoint and the requested run, in words: "it is of another scene:
/// 'speed = 0.1' there, 'speed = 0.2' here"; empty where a run can go on from it.
std::string difference(const Checkpoint& checkpoint, const Identity& run, const Model& model,
                       Outputs outputs = Outputs::kept);

/// Writes a checkpoint; the one before is kept, if the last is damaged the one before that. Throws
/// FileError.
void write_checkpoint(const ClaimedOutput& output, const Checkpoint& checkpoint,
                      bool last_is_damaged);

struct FoundCheckpoint {
  std::optional<Checkpoint> checkpoint;  // to go on from
  std::filesystem::path file;            // that it was in
  std::string damage;  // of one that is newer, or of all that there are; empty where there is none
  std::string difference;  // why the one that is whole is of another run; empty where it is not
};

/// Looks for the last checkpoint of an output that a run can go on from: the one before it where
/// the last is damaged, or segments that it vouches for. Faults are found, not thrown.
FoundCheckpoint find_checkpoint(const OutputNames& names, const Identity& run, const Model& model,
                                Outputs outputs);

}  // namespace ra2d
