// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "kernels/nodes.hpp"

/// A scene: what the user asked for, complete and checked. All in SI units.
namespace ra2d {

/// Plane: beams, and every asperity is a ridge as wide as the slider. Areal: a plate and a block
/// with height maps.
enum class SceneKind { plane, areal };
enum class BodyKind { beam, plate, block };
enum class Support { pinned, free, rigid };
enum class SurfaceKind { flat, peaks, file, gaussian };
/// A face between its nodes: straight lines, or a cubic spline.
enum class Faces { linear, smooth };
enum class Initial { rest, statics };  // "rest", "static"
enum class ContactLaw { penalty, multiplier };
enum class SchemeKind {
  explicit_euler,
  midpoint,
  backward_euler,
  heun,
  rk4,
  rk8,
  exact,
  gautschi,
  adaptive
};
/// When backward Euler takes the penalty force.
enum class ForceTime { old_time, new_time };

/// One raised cosine: height/2 (1 + cos(pi (x - at)/half_width)) within |x - at| <= half_width.
struct Peak {
  double at = 0;          // m, along the beam
  double height = 0;      // m
  double half_width = 0;  // m
};

/// The autocorrelation of a random surface.
enum class Correlation { gaussian, exponential, self_affine };
/// The values that a random surface has exactly over the beam's length. The others hold in
/// expectation.
enum class Exactly { rq, rq_and_rsm, nothing };

/// The unit of the numbers in a file.
enum class FileUnit { m, mm, um, nm };
/// The mark before the decimals of a file.
enum class FileDecimal { point, comma };
enum class FaceFilter { none, gaussian };
/// How a profile is treated that is shorter than the beam, and a map that is smaller than the body.
enum class ShortProfile { refuse, repeat, mirror };

/// How a measured profile is read and prepared, where its file does not say so.
struct FilePreparation {
  std::optional<FileUnit> x_unit, z_unit;
  std::optional<double> spacing;             // m, of a file that has no x
  std::optional<double> spacing_y;           // m, of a map's file that has none; none: as spacing
  std::optional<double> offset_x, offset_y;  // m, of a map: where it begins on the body
  std::optional<FileDecimal> decimal;        // none: as the file has it
  std::optional<int> row, column;            // from 1
  std::string form, fill;                    // "line", "plane", "linear:1e-5"; empty: none
  FaceFilter filter = FaceFilter::none;
  std::optional<double> cutoff, cutoff_s;  // m
  ShortProfile when_short = ShortProfile::refuse;
  bool operator==(const FilePreparation&) const = default;
};

/// A rough face, its heights positive towards the opposite body.
struct SurfaceSpec {
  SurfaceKind kind = SurfaceKind::flat;
  std::vector<Peak> peaks;     // peaks
  std::filesystem::path path;  // file: as written, relative to the scene's folder
  FilePreparation prepared;    // file
  // gaussian
  double rq = 0;                // m, root mean square height
  std::optional<double> rsm;    // m, mean spacing of the profile elements; or
  std::optional<double> rsm_y;  // m, of a map: rsm along y; infinite: every row is alike
  std::optional<double> correlation_length;  // m, the distance at which the correlation is 1/e
  Correlation correlation = Correlation::gaussian;
  std::optional<double> hurst;               // self-affine: Hurst exponent
  std::optional<double> longest, shortest;   // m, waves; shortest: exponential, too
  std::optional<double> skewness, kurtosis;  // of the heights; none: 0 and 3
  Exactly exact = Exactly::rq;
  std::uint64_t seed = 0;
};

/// A constant force that travels along the resonator, positive upwards.
struct MovingForce {
  double force = 0;              // N
  double speed = 0;              // m/s
  double start = 0;              // m, where it stands at t = 0
  std::optional<double> y = {};  // m, areal scenes: across the resonator
};

struct BodySpec {
  BodyKind kind = BodyKind::beam;  // follows from that of the scene
  Support support = Support::pinned;
  double length = 0;                    // m
  double thickness = 0;                 // m
  double width = 0;                     // m
  double young = 0;                     // Pa
  double density = 0;                   // kg/m^3
  std::optional<double> poisson;        // of plates and contact.stiffness = "hertz"; none: 0.3
  double damping = 0;                   // modal damping ratio zeta
  std::optional<double> max_frequency;  // Hz, keep the elastic modes up to here; or
  std::optional<int> modes;             // keep this many elastic modes
  SurfaceSpec surface;
  bool load_is_weight = false;             // slider: load = "weight", or "2 weight":
  double load_weights = 1;                 // so many times its weight
  double load = 0;                         // slider: N towards the resonator, when not its weight
  std::vector<MovingForce> moving_forces;  // resonator
};

struct ContactSettings {
  ContactLaw law = ContactLaw::penalty;
  double stiffness = 0;   // Pa/m, kappa
  bool is_hertz = false;  // stiffness = "hertz": found from the bodies' materials
};

/// Comparisons of schemes use it, too: with `scheme` and `contact_force`, and no step.
struct TimeSettings {
  SchemeKind scheme = SchemeKind::backward_euler;
  ForceTime contact_force = ForceTime::old_time;
  double step = 0;                  // s, tau; 0: none, which adaptive does without
  std::optional<double> tolerance;  // adaptive: relative local error per step
  Nodes nodes = Nodes::candidates;
  bool force = false;  // run beyond the limit of stability, too
  bool operator==(const TimeSettings&) const = default;
};

enum class KeptModes { all, none };
enum class Precision { real64, real32 };
enum class Compression { none, deflate };

/// A place above the resonator: along it from its left end, across it from its edge, above it.
struct MicrophonePlace {
  double x = 0, y = 0, z = 0;  // m
  bool operator==(const MicrophonePlace&) const = default;
};

inline constexpr double nearest_microphone = 1e-3;  // m, from the resonator's plane
inline constexpr double farthest_microphone = 100;  // m, from the resonator

/// The air that carries the sound to the microphones.
struct AirSettings {
  double celsius = 20;
  double pascal = 101'325;
  bool operator==(const AirSettings&) const = default;
};

/// A place on a body: along it, and in areal scenes across it.
struct ProbePlace {
  double x = 0;             // m
  std::optional<double> y;  // m
  ProbePlace(double along = 0, std::optional<double> across = {}) : x{along}, y{across} {}
  bool operator==(const ProbePlace&) const = default;
};

struct OutputSettings {
  double rate = 0;                        // Hz, samples at t_j = j / rate
  std::vector<ProbePlace> probes;         // on the resonator
  std::vector<ProbePlace> slider_probes;  // on the slider
  std::vector<MicrophonePlace> microphones;
  double from = 0;             // s: level, energy balance and shock statistics begin here
  std::vector<double> window;  // s, beginning and end of what is sampled; empty: all
  // of what is sampled, in a file:
  KeptModes modes = KeptModes::all;
  Precision precision = Precision::real64;
  Compression compression = Compression::none;
};

/// Its members are the sections of a scene's TOML, and those of [scene] itself.
struct Scene {
  std::filesystem::path file;  // where it was read from; its folder anchors relative paths
  /// The line of each "section.key", for faults that are found later; none: made in code.
  std::shared_ptr<const std::map<std::string, std::string>> places;

  std::string name;
  SceneKind kind = SceneKind::plane;
  double duration = 0;        // s
  double speed = 0;           // m/s, V >= 0
  double start = 0;           // m, the slider's left end on the resonator at t = 0
  std::optional<double> gap;  // m, delta between the mean lines; none: "touching"
  double spacing = 0;         // m, chi
  // of areal scenes; both are there when a scene has been read
  std::optional<double> spacing_y;  // m, chi_y, between rows of nodes; none: as spacing
  std::optional<double> side;       // m, y0, of the slider on the resonator; none: in its middle
  Faces faces = Faces::linear;      // of a file without the key: smooth, if the scene is plane
  Initial initial =
      Initial::rest;  // of a file without the key: statics, where there is an equilibrium

  BodySpec resonator, slider;

  ContactSettings contact;
  TimeSettings time;
  OutputSettings output;
  AirSettings air;
};

/// The tolerance of an adaptive scene without the key.
inline constexpr double usual_tolerance = 1e-8;

/// Makes a scene areal: sets the kinds of its bodies and the values that follow from other keys.
void make_areal(Scene& scene);

/// Gives a scene another spacing, and an areal one another spacing_y in the same proportion.
void set_spacing(Scene& scene, double spacing);

/// How often nodes of linear faces pass one another, which makes a tone [Hz]; 0 where none do.
double mesh_tone_frequency(const Scene& scene);

/// Whether loads and contact can hold the scene's bodies in equilibrium: not a free resonator, nor
/// a free slider that no load presses down.
bool has_equilibrium(const Scene& scene);

/// A fault of a scene that is found after it was read, at "section.key". Its message is like those
/// of the reading.
RequestError refusal(const Scene& scene, const std::string& key, const std::string& what);

/// The place of a key: "FILE:LINE", or the override. Of a key that is not there: the place of its
/// section, or the file.
std::string place_of(const Scene& scene, std::string key);

/// The files that a scene is read from: its own, and its measured profiles.
std::vector<std::filesystem::path> files_of(const Scene& scene);

/// The scene without the values that change no bit of its run: its name, and those that its contact
/// stiffness was found from.
Scene without_origins(Scene scene);

/// The scene's name, or that of its file.
std::string title(const Scene& scene);

}  // namespace ra2d
