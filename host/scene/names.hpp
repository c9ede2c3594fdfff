// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "host/scene/scene.hpp"

/// The words of a scene's choices in TOML.
namespace ra2d {

template <class E>
struct Choices {
  std::vector<std::pair<std::string, E>> words;

  const std::string& name(E value) const {
    for (const auto& [word, candidate] : words)
      if (candidate == value) return word;
    return words.front().first;  // not reached: every value has its word
  }
};

inline const Choices<SceneKind> scene_kinds{
    {{"plane", SceneKind::plane}, {"areal", SceneKind::areal}}};
inline const Choices<Support> supports{
    {{"pinned", Support::pinned}, {"free", Support::free}, {"rigid", Support::rigid}}};
inline const Choices<SurfaceKind> surface_kinds{{{"gaussian", SurfaceKind::gaussian},
                                                 {"file", SurfaceKind::file},
                                                 {"peaks", SurfaceKind::peaks},
                                                 {"flat", SurfaceKind::flat}}};
inline const Choices<Correlation> correlations{{{"gaussian", Correlation::gaussian},
                                                {"exponential", Correlation::exponential},
                                                {"self-affine", Correlation::self_affine}}};
inline const Choices<Exactly> exact_choices{
    {{"rq", Exactly::rq}, {"rq+rsm", Exactly::rq_and_rsm}, {"none", Exactly::nothing}}};
inline const Choices<FileUnit> file_units{
    {{"m", FileUnit::m}, {"mm", FileUnit::mm}, {"um", FileUnit::um}, {"nm", FileUnit::nm}}};
inline const Choices<FileDecimal> file_decimals{
    {{"point", FileDecimal::point}, {"comma", FileDecimal::comma}}};
inline const Choices<FaceFilter> face_filters{
    {{"gaussian", FaceFilter::gaussian}, {"none", FaceFilter::none}}};
inline const Choices<ShortProfile> short_profiles{{{"refuse", ShortProfile::refuse},
                                                   {"repeat", ShortProfile::repeat},
                                                   {"mirror", ShortProfile::mirror}}};
inline const Choices<Faces> face_choices{{{"linear", Faces::linear}, {"smooth", Faces::smooth}}};
inline const Choices<Initial> initial_states{
    {{"rest", Initial::rest}, {"static", Initial::statics}}};
inline const Choices<ContactLaw> contact_laws{
    {{"penalty", ContactLaw::penalty}, {"multiplier", ContactLaw::multiplier}}};
inline const Choices<SchemeKind> schemes{{{"explicit-euler", SchemeKind::explicit_euler},
                                          {"midpoint", SchemeKind::midpoint},
                                          {"backward-euler", SchemeKind::backward_euler},
                                          {"heun", SchemeKind::heun},
                                          {"rk4", SchemeKind::rk4},
                                          {"rk8", SchemeKind::rk8},
                                          {"exact", SchemeKind::exact},
                                          {"gautschi", SchemeKind::gautschi},
                                          {"adaptive", SchemeKind::adaptive}}};
inline const Choices<ForceTime> force_times{
    {{"old", ForceTime::old_time}, {"new", ForceTime::new_time}}};
inline const Choices<KeptModes> kept_modes{{{"all", KeptModes::all}, {"none", KeptModes::none}}};
inline const Choices<Precision> precisions{
    {{"double", Precision::real64}, {"float", Precision::real32}}};
inline const Choices<Compression> compressions{
    {{"none", Compression::none}, {"deflate", Compression::deflate}}};
inline const Choices<Nodes> node_choices{{{"candidates", Nodes::candidates}, {"all", Nodes::all}}};

}  // namespace ra2d
