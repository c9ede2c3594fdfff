// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/chart_points.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/base/errors.hpp"
#include "host/base/format.hpp"
#include "host/plan/plan.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {

std::vector<ChartPoint> list_points(Survey& survey) {
  survey.say("limits of stability");
  std::vector<ChartPoint> points;
  const JoinedModes place =
      most_compliant(survey.model_of(with(survey.scene, survey.methods.front())));
  for (const Method& method : survey.methods) {
    const bool chooses = is_adaptive(method.time);
    std::string hindrance;
    double holds = quiet_nan;
    for (const double size : chooses ? survey.options.tolerances : survey.options.steps) {
      const Method setting = sized(method, size);
      Measured row{.name = name_of(setting), .setting = setting};
      const Model model = survey.model_of(with(survey.scene, setting));
      if (hindrance.empty() && method.law == ContactLaw::multiplier) try {
          hindrance = overlap_at_start(model);
          survey.start_of(method.law, model);
        } catch (const RequestError& fault) {
          hindrance = fault.what();
        }
      row.left_out = hindrance;
      if (!chooses && hindrance.empty()) {
        if (std::isnan(holds)) holds = step_limits(model, method.time, place).holds();
        const StepLimits limits{.modes = holds, .contact_one = holds};
        if (!beyond_limit(model, limits).empty())
          row.left_out = holds > 0 ? fmt::format("beyond its limit of {} s", rounded_down(holds))
                                   : std::string("grows at every step");
      }
      if (row.left_out.empty()) points.push_back({survey.chart.points.size(), model});
      survey.chart.points.push_back(std::move(row));
    }
  }
  return points;
}

}  // namespace ra2d
