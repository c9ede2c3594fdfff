// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/pressure.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "host/base/fourier.hpp"

namespace ra2d {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t least_block = 2048, slack = 8;          // samples
constexpr std::size_t bytes_at_once = std::size_t{32} << 20;  // of a record

/// Kaiser's window for 180 dB, which the band's two edges ask for with `filter_half_length`.
double kaiser(double u) {
  constexpr double sharpness = 18.88;
  return std::cyl_bessel_i(0, sharpness * std::sqrt(std::max(0.0, 1 - u * u))) /
         std::cyl_bessel_i(0, sharpness);
}

/// i omega times the low pass, delayed by `filter_half_length` samples, at the lines of a block:
/// from velocity to acceleration.
std::vector<Complex> differentiating_lines(double rate, std::size_t block) {
  constexpr double middle = (passed + stopped) / 2;  // of half the rate
  Fourier fourier(block);
  const auto input = fourier.input();
  std::fill(input.begin(), input.end(), 0.0);
  constexpr auto half = static_cast<double>(filter_half_length);
  for (std::size_t n = 0; n <= 2 * filter_half_length; ++n) {
    const double t = static_cast<double>(n) - half;
    const double low = t == 0 ? middle : std::sin(M_PI * middle * t) / (M_PI * t);
    input[n] = low * kaiser(t / half);
  }
  fourier.transform();
  std::vector<Complex> lines(fourier.lines());
  for (std::size_t j = 0; j < lines.size(); ++j)
    lines[j] = Complex(0, 2 * M_PI * static_cast<double>(j) * rate / static_cast<double>(block)) *
               fourier.line(j);
  return lines;
}

std::size_t taps_of(double path_length, const Air& air, double rate) {
  return static_cast<std::size_t>(std::ceil(path_length / air.sound_speed * rate)) +
         2 * filter_half_length + slack;
}

std::size_t block_of(std::size_t taps) { return std::max(least_block, std::bit_ceil(4 * taps)); }

/// Sum over the modes of spectrum times filter, each of `lines` complex numbers a mode.
void add_up(const std::vector<double>& re, const std::vector<double>& im,
            const std::vector<double>& filter_re, const std::vector<double>& filter_im,
            std::size_t lines, std::span<Complex> sum) {
  std::vector<double> sum_re(lines, 0.0), sum_im(lines, 0.0);
  for (std::size_t at = 0; at < re.size(); at += lines) {
    const double *a = &re[at], *b = &im[at], *c = &filter_re[at], *d = &filter_im[at];
    for (std::size_t j = 0; j < lines; ++j) {
      sum_re[j] += a[j] * c[j] - b[j] * d[j];
      sum_im[j] += a[j] * d[j] + b[j] * c[j];
    }
  }
  for (std::size_t j = 0; j < lines; ++j) sum[j] = Complex(sum_re[j], sum_im[j]);
  sum[0] = sum[0].real();
  sum[lines - 1] = sum[lines - 1].real();
}

}  // namespace

PressureFilters::PressureFilters(const Radiator& radiator, const Air& air,
                                 const std::vector<Position>& places, double rate,
                                 const Fineness& fineness)
    : modes_{radiator.modes.size()} {
  std::size_t most = 0;
  for (const Position& place : places) {
    const Distances ways = distances(radiator, place);
    most = std::max(most, taps_of(ways.largest - ways.least, air, rate));
  }
  block_ = block_of(most);
  const std::vector<Complex> differentiating = differentiating_lines(rate, block_);
  for (const Position& place : places) {
    const TransferLines lines = transfer_lines(radiator, air, place, rate, block_, fineness);
    Filter filter;
    filter.lead = lines.lead;
    filter.taps = most;
    for (const std::vector<Complex>& mode : lines.modes)
      for (std::size_t j = 0; j < mode.size(); ++j) {
        const Complex value = mode[j] * differentiating[j];
        filter.re.push_back(value.real());
        filter.im.push_back(value.imag());
      }
    filters_.push_back(std::move(filter));
  }
}

double PressureFilters::bytes(const Radiator& radiator, const Air& air, std::size_t places,
                              double rate, std::size_t samples) {
  const double path_length = std::hypot(radiator.length, radiator.width);
  const auto lines = static_cast<double>(block_of(taps_of(path_length, air, rate)) / 2 + 1);
  const auto modes = static_cast<double>(radiator.modes.size());
  const double pressures = static_cast<double>(samples) * sizeof(double);
  return static_cast<double>(places) * (lines * modes * sizeof(Complex) + pressures) +
         std::min(static_cast<double>(bytes_at_once), pressures * modes);
}

PressureFilters::Range PressureFilters::carried(std::size_t place,
                                                const VelocityRecord& record) const {
  const Filter& filter = filters_[place];
  Range range;
  if (!record.rests_before) range.begin = filter.lead + filter.taps - filter_half_length;
  range.end = record.samples + filter.lead;
  range.end -= std::min(range.end, filter_half_length);
  return range;
}

std::vector<std::vector<double>> PressureFilters::pressures(
    const VelocityRecord& record, const std::vector<Range>& ranges) const {
  std::vector<std::vector<double>> found;
  // output n of the convolution is the pressure at sample n + lead - reach
  std::size_t begin = record.samples, end = 0;
  const auto output_of = [&](std::size_t place, std::size_t sample) {
    const std::size_t ahead = sample + filter_half_length;
    return ahead - std::min(ahead, filters_[place].lead);
  };
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    found.emplace_back(ranges[i].count(), 0.0);
    if (ranges[i].count() == 0) continue;
    begin = std::min(begin, output_of(i, ranges[i].begin));
    end = std::max(end, output_of(i, ranges[i].end));
  }
  end = std::min(end, record.samples);
  if (begin >= end || modes_ == 0) return found;

  const std::size_t before = filters_.front().taps - 1, fresh = block_ - before;
  const std::size_t lines = block_ / 2 + 1;
  const std::size_t blocks_at_once =
      std::max<std::size_t>(1, bytes_at_once / sizeof(double) / modes_ / fresh);
  Fourier forth(block_);
  BackFourier back(block_);
  std::vector<double> re(modes_ * lines), im(re.size());
  for (std::size_t chunk = begin; chunk < end; chunk += blocks_at_once * fresh) {
    const std::size_t chunk_end = std::min(end, chunk + blocks_at_once * fresh);
    const std::size_t read_from = chunk - std::min(chunk, before);
    const auto velocity = record.read(read_from, chunk_end - read_from);
    for (std::size_t first = chunk; first < chunk_end; first += fresh) {
      const std::size_t last = std::min(chunk_end, first + fresh);
      for (std::size_t k = 0; k < modes_; ++k) {
        const auto input = forth.input();
        std::fill(input.begin(), input.end(), 0.0);
        // input[n] is sample first - before + n
        const std::size_t from = first - std::min(first, before);
        std::copy(velocity[k].begin() + static_cast<std::ptrdiff_t>(from - read_from),
                  velocity[k].begin() + static_cast<std::ptrdiff_t>(last - read_from),
                  input.begin() + static_cast<std::ptrdiff_t>(from + before - first));
        forth.transform();
        for (std::size_t j = 0; j < lines; ++j) {
          re[k * lines + j] = forth.line(j).real();
          im[k * lines + j] = forth.line(j).imag();
        }
      }
      for (std::size_t i = 0; i < filters_.size(); ++i) {
        const Filter& filter = filters_[i];
        add_up(re, im, filter.re, filter.im, lines, back.input());
        back.transform();
        for (std::size_t n = first; n < last; ++n) {
          const std::size_t sample = n + filter.lead;
          if (sample < filter_half_length + ranges[i].begin ||
              sample >= filter_half_length + ranges[i].end)
            continue;
          found[i][sample - filter_half_length - ranges[i].begin] =
              back.output()[n - first + before] / static_cast<double>(block_);
        }
      }
    }
  }
  return found;
}

}  // namespace ra2d
