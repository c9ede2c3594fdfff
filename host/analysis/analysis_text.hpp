// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/analysis/analysis.hpp"

/// An analysis as text: for people, for programs (docs/analysis.md) and for tables.
namespace ra2d {

/// The intervals of one run, to stand behind its level and its rate of shocks: "; 95 %: ..." or why
/// there is none.
std::string interval_text(const IntervalsOfRun& intervals);
std::string rate_interval_text(const IntervalsOfRun& intervals);

/// The text for a tone that stands out.
std::string mesh_tone_text(const MeshTone& mesh);

/// One screen.
std::string describe(const Analysis& analysis);

/// The part of it about sound; nothing where none was asked for.
std::string describe_sound(const Analysis& analysis);

/// The means of several, a line a figure.
std::string describe_means(const std::vector<Analysis>& analyses);

/// One object, or of several {"files": [...], "mean": {...}}; null for what is not finite. Ends
/// with a line end.
std::string json_of(const std::vector<Analysis>& analyses);

/// Comma-separated, with a first line of names: the spectrum's lines, the bands, and the bins of
/// the shocks' histograms.
std::string spectrum_csv(const Analysis& analysis);
std::string bands_csv(const Analysis& analysis);
std::string shocks_csv(const Analysis& analysis);
/// Third octaves of each microphone, and of the sound power.
std::string sound_csv(const Analysis& analysis);
/// The level at each microphone in time.
std::string sound_history_csv(const Analysis& analysis);

/// Level and rate of shocks of each result with its own interval, and of several their means with
/// theirs.
std::string figures_csv(const std::vector<Analysis>& analyses);

}  // namespace ra2d
