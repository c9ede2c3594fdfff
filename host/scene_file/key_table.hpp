// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "host/scene_file/key.hpp"

/// The table of all keys of a scene. Reading, the ranges, the echo, the units of a study's columns,
/// suggestions for misspelt keys and the tables of docs/scene.md are made from it.
namespace ra2d::keys {

const Keys<Scene>& of_scene();
const Keys<BodySpec>& of_resonator();
const Keys<BodySpec>& of_slider();
const Keys<SurfaceSpec>& of_surface();
const Keys<Peak>& of_peak();
const Keys<MovingForce>& of_moving_force();
const Keys<ContactSettings>& of_contact();
const Keys<TimeSettings>& of_time();
const Keys<OutputSettings>& of_output();
const Keys<MicrophonePlace>& of_microphone();
const Keys<AirSettings>& of_air();

/// Whether the bodies' elastic constants give the contact its stiffness.
bool takes_hertz(const ContactSettings& contact);

}  // namespace ra2d::keys
