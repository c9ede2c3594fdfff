// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/model/model.hpp"

/// The key of a run: two runs of one key give the same bits.
namespace ra2d {

/// To be raised with every change of the bits of an answer on purpose (CONTRIBUTING.md).
inline constexpr int numerics_version = 2;

/// numerics_version of a scene: higher for the kinds of scenes whose bits changed when those of the
/// others did not.
int numerics_version_of(const Scene& scene);

/// XXH3-128, as 32 hexadecimal digits, of the scene with all its keys, of both bodies' heights, of
/// the version of the numerics and of the build's arithmetic. Neither the scene's name nor the
/// place of its files is in it, nor the number of threads.
std::string run_key(const Model& model);

/// As run_key(), of a run of which what microphones hear is kept, too: other microphones or other
/// air make another key.
std::string run_key_with_sound(const Model& model);

/// The microphones and the air of a scene as text; nothing where it has no microphone and the usual
/// air. Its motion does not depend on them.
std::string sound_settings(const Scene& scene);

/// The first difference of two scenes, as echo() writes them: "'speed = 0.1' there, 'speed = 0.2'
/// here". Empty where they do not; their names are no difference.
std::string first_difference(const std::string& there, const std::string& here);

}  // namespace ra2d
