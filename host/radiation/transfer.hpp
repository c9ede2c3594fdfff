// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "host/radiation/air.hpp"
#include "host/radiation/quadrature.hpp"
#include "host/radiation/radiator.hpp"

/// From a mode's acceleration to the pressure at a place, by Rayleigh's integral:
///   H_k(f) = density/(2 pi) integral psi_k exp(-i omega R/c) / R dA,
/// R the distance from the point of the face. Nothing is assumed of distance or wavelength.
namespace ra2d {

/// x, y, z [m]. Above the face z > 0. Below it the pressure is that above with the other sign.
using Position = std::array<double, 3>;

/// The least and the largest distance from the face [m].
struct Distances {
  double least = 0, largest = 0;
};
Distances distances(const Radiator& radiator, const Position& at);

/// How many points of the face the integral takes for a pressure up to half this rate [Hz], about:
/// more for places that are near.
double face_points(const Radiator& radiator, const Air& air, double rate);

/// H_k at one frequency [Hz], of each mode [kg/m^3 m^2/m = Pa/(m/s^2) per unit of psi].
std::vector<std::complex<double>> transfer(const Radiator& radiator, const Air& air,
                                           const Position& at, double frequency,
                                           const Fineness& fineness = {});

/// H_k at the lines j rate/length for j = 0 ... length/2, of each mode, with the delay of `lead`
/// samples taken off: that of the shortest way, rounded down. All lines come from one set of
/// points, whose arrivals are spread over a grid of time (a nonuniform Fourier transform); they are
/// right to 1e-9 of the largest.
struct TransferLines {
  std::size_t lead = 0;  // samples
  std::vector<std::vector<std::complex<double>>> modes;
};
TransferLines transfer_lines(const Radiator& radiator, const Air& air, const Position& at,
                             double rate, std::size_t length, const Fineness& fineness = {});

}  // namespace ra2d
