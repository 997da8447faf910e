/* The closed loop as one writes it by hand: one lane after the other, all of it in registers.

   The law is that of plants/ and design/, term by term.  `layout.h` numbers the rows of
   `coef` and `state` in the order of SampledClosedLoop and ClosedLoop of plants.simulation.closed_loop; it is
   written by benchmarks/native.py. */

#include <math.h>
#include <stddef.h>

#include "layout.h"

#define C(name) coef[(size_t)coef_##name * lanes + lane]
#define S(name) state[(size_t)state_##name * lanes + lane]

void rollouts(int lanes, int steps, const double *coef, double *state) {
    for (int lane = 0; lane < lanes; lane++) {
        const double gain = C(plant_regulator_gain), e0_squared = C(plant_regulator_e0_squared);
        const double alpha_slow = C(plant_regulator_alpha_slow), alpha_rise = C(plant_regulator_alpha_rise);
        const double z_rise = C(plant_regulator_z_rise), z_centre = C(plant_regulator_z_centre);
        const double a1 = C(plant_a1), w1 = C(plant_w1), a2 = C(plant_a2), w2 = C(plant_w2), s = C(plant_s);
        const double rest = C(plant_rest_pressure);
        const double keep = C(plant_lag_keep), before = C(plant_lag_before), after = C(plant_lag_after);
        const double Kp = C(controller_Kp), Ki_dt = C(controller_Ki_dt);
        const double volts_per_kPa = C(controller_volts_per_kPa), held = C(controller_rest_pressure);
        const double low = C(controller_low), high = C(controller_high);
        const double reference = C(reference_references_0), start = C(judge_step_start);
        const double per_step = C(judge_step_per_step), dt = C(judge_dt);

        double pressure = S(plant_pressure), h = S(plant_memory_h), angle = S(plant_angle);
        int virgin = S(plant_memory_virgin) != 0.0;
        double integral = S(controller_integral), last = S(judge_command);
        double iae = 0.0, ise = 0.0, itae = 0.0, variation = 0.0, peak = 0.0, error = 0.0;
        int below10 = 0, below90 = 0, outside = 0;

        for (int k = 0; k < steps; k++) {
            /* PI, the integrator stopped while it would push the clipped command further out */
            error = reference - angle;
            const double wanted = (held + Kp * error + integral) * volts_per_kPa;
            const double command = wanted < low ? low : wanted > high ? high : wanted;
            if (!((wanted - command) * error > 0.0)) integral += Ki_dt * error;

            /* metrics */
            const double size = fabs(error) * dt;
            iae += size;
            ise += size * fabs(error);
            itae += size * (k * dt);
            variation += fabs(command - last);
            last = command;
            const double response = (angle - start) * per_step;
            if (response > peak) peak = response;
            below10 += peak < 0.1;
            below90 += peak < 0.9;
            if (fabs(error * per_step) >= 0.02) outside = k + 1;

            /* regulator */
            const double e = gain * command - pressure, squared = e * e;
            const double w = squared / (squared + e0_squared);
            const double alpha = alpha_slow + w * (alpha_rise - (1.0 - w) * z_rise * (z_centre + w * z_rise));
            const double now = pressure + alpha * e;

            /* hysteresis */
            const double inside = virgin ? h : h + s * (now - pressure);
            const double line1 = a1 * (now - rest) - w1, line2 = a2 * (now - rest) + w2;
            const double raised = inside > line1 ? inside : line1;
            const double moved = raised < line2 ? raised : line2;
            virgin &= moved == inside;

            /* lag */
            angle = keep * angle + before * h + after * moved;
            pressure = now;
            h = moved;
        }

        S(plant_pressure) = pressure, S(plant_memory_h) = h, S(plant_memory_virgin) = virgin;
        S(plant_angle) = angle, S(controller_integral) = integral;
        S(judge_iae) = iae, S(judge_ise) = ise, S(judge_itae) = itae, S(judge_variation) = variation;
        S(judge_command) = last, S(judge_peak) = peak, S(judge_error) = error;
        S(judge_below10) = below10, S(judge_below90) = below90, S(judge_outside) = outside;
    }
}
