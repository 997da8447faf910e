/* The closed loop by hand, as fast as we know how: four interleaved vectors of four lanes
   (-DWIDTH and -DTOGETHER make it others).

   The law is that of plants/ and design/, rearranged as far as real numbers allow: the command
   and the integral in volts, the polynomial of the regulator's rate in Horner's form, the slope
   of the transit held instead of the mark of the virgin curve, sums without the sample time.
   What does not change within a rollout is computed before it.  `layout.h` numbers the rows
   of `coef` and `state` in the order of SampledClosedLoop and ClosedLoop of plants.simulation.closed_loop; it is
   written by benchmarks/native.py.

   Compiled with -ffast-math: nothing in here may be infinite, so the times come out as counts. */

#include <stdint.h>
#include <string.h>

#include "layout.h"

#ifndef WIDTH
#define WIDTH 4
#define TOGETHER 4
#endif

typedef double vec __attribute__((vector_size(8 * WIDTH)));
typedef int64_t mask __attribute__((vector_size(8 * WIDTH))); /* -1 where true */

static inline vec load(const double *p) {
    vec v;
    memcpy(&v, p, sizeof v);
    return v;
}
static inline void store(double *p, vec v) { memcpy(p, &v, sizeof v); }
static inline vec where(mask m, vec a) { return (vec)(m & (mask)a); } /* else 0 */
static inline vec choose(mask m, vec a, vec b) { return (vec)((m & (mask)a) | (~m & (mask)b)); }
static inline vec magnitude(vec a) { return (vec)((mask)a & INT64_MAX); }

/* GNU C has no minimum of vectors; a loop over the elements becomes the one instruction. */
static inline vec lower(vec a, vec b) {
    vec r;
    for (int i = 0; i < WIDTH; i++) r[i] = a[i] < b[i] ? a[i] : b[i];
    return r;
}
static inline vec upper(vec a, vec b) {
    vec r;
    for (int i = 0; i < WIDTH; i++) r[i] = a[i] > b[i] ? a[i] : b[i];
    return r;
}

typedef struct {
    vec gain, alpha0, alpha1, alpha2, alpha3, e0_squared; /* alpha = sum of alpha_i w^i */
    vec a1, b1, a2, b2, s;                                /* line 1 is a1 P + b1 */
    vec keep, before, after;
    vec Kp, Ki_dt, low, high; /* in volts */
    vec reference, per_step, offset, band;
} Lane;

typedef struct {
    vec pressure, h, slope, angle, integral; /* integral in volts, rest pressure included */
    vec iae, ise, itae, variation, command, peak, outside;
    mask below10, below90;
} Now;

static inline void step(Now *s, const Lane *c, vec k) {
    vec error = c->reference - s->angle, size = magnitude(error);
    vec wanted = c->Kp * error + s->integral;
    vec command = lower(upper(wanted, c->low), c->high);
    s->integral += where((wanted - command) * error <= 0.0, c->Ki_dt * error);

    s->iae += size;
    s->ise += error * error;
    s->itae += size * k;
    s->variation += magnitude(command - s->command);
    s->command = command;
    s->peak = upper(s->peak, s->angle * c->per_step + c->offset);
    s->below10 += s->peak < 0.1;
    s->below90 += s->peak < 0.9;
    s->outside = choose(size >= c->band, k + 1.0, s->outside);

    vec e = c->gain * command - s->pressure, squared = e * e;
    vec w = squared / (squared + c->e0_squared);
    vec moved = (c->alpha0 + w * (c->alpha1 + w * (c->alpha2 + w * c->alpha3))) * e;
    vec pressure = s->pressure + moved;

    vec inside = s->h + s->slope * moved;
    vec h = lower(upper(inside, c->a1 * pressure + c->b1), c->a2 * pressure + c->b2);
    s->slope = (vec)((mask)s->slope | ((h != inside) & (mask)c->s)); /* 0 or s, and s stays */
    s->angle = c->keep * s->angle + c->before * s->h + c->after * h;
    s->pressure = pressure;
    s->h = h;
}

#define C(name) load(coef + (size_t)coef_##name * lanes + first)
#define S(name) (state + (size_t)state_##name * lanes + first)

static Lane prepare(int lanes, int first, const double *coef) {
    Lane c;
    vec rise = C(plant_regulator_z_rise), centre = C(plant_regulator_z_centre);
    vec rest = C(plant_rest_pressure), volts = C(controller_volts_per_kPa);
    vec per_step = C(judge_step_per_step);
    c.gain = C(plant_regulator_gain);
    c.alpha0 = C(plant_regulator_alpha_slow);
    c.alpha1 = C(plant_regulator_alpha_rise) - rise * centre;
    c.alpha2 = rise * (centre - rise);
    c.alpha3 = rise * rise;
    c.e0_squared = C(plant_regulator_e0_squared);
    c.a1 = C(plant_a1), c.b1 = -c.a1 * rest - C(plant_w1);
    c.a2 = C(plant_a2), c.b2 = -c.a2 * rest + C(plant_w2);
    c.s = C(plant_s);
    c.keep = C(plant_lag_keep), c.before = C(plant_lag_before), c.after = C(plant_lag_after);
    c.Kp = C(controller_Kp) * volts, c.Ki_dt = C(controller_Ki_dt) * volts;
    c.low = C(controller_low), c.high = C(controller_high);
    c.reference = C(reference_references_0);
    c.per_step = per_step, c.offset = -C(judge_step_start) * per_step;
    c.band = 0.02 / magnitude(per_step);
    return c;
}

/* `lanes` has to be a multiple of WIDTH * TOGETHER. */
void rollouts(int lanes, int steps, const double *coef, double *state) {
    for (int block = 0; block < lanes; block += WIDTH * TOGETHER) {
        Lane c[TOGETHER];
        Now s[TOGETHER];
        for (int i = 0; i < TOGETHER; i++) {
            int first = block + i * WIDTH;
            c[i] = prepare(lanes, first, coef);
            vec virgin = load(S(plant_memory_virgin)), volts = C(controller_volts_per_kPa);
            s[i] = (Now){
                load(S(plant_pressure)), load(S(plant_memory_h)), c[i].s * (1.0 - virgin), load(S(plant_angle)),
                (C(controller_rest_pressure) + load(S(controller_integral))) * volts,
            };
            s[i].command = load(S(judge_command)); /* the sums begin at zero */
        }
        vec k = {0}, error[TOGETHER];
        for (int n = 1; n < steps; n++) { /* all samples but the last, of which the error is kept */
#pragma GCC unroll 8
            for (int i = 0; i < TOGETHER; i++) step(&s[i], &c[i], k);
            k += 1.0;
        }
        for (int i = 0; i < TOGETHER; i++) {
            error[i] = c[i].reference - s[i].angle;
            step(&s[i], &c[i], k);
        }
        for (int i = 0; i < TOGETHER; i++) {
            int first = block + i * WIDTH;
            vec dt = C(judge_dt);
            store(S(plant_pressure), s[i].pressure);
            store(S(plant_memory_h), s[i].h);
            store(S(plant_memory_virgin), -__builtin_convertvector(s[i].slope == 0.0, vec));
            store(S(plant_angle), s[i].angle);
            store(S(controller_integral),
                  s[i].integral / C(controller_volts_per_kPa) - C(controller_rest_pressure));
            store(S(judge_iae), s[i].iae * dt);
            store(S(judge_ise), s[i].ise * dt);
            store(S(judge_itae), s[i].itae * dt * dt);
            store(S(judge_variation), s[i].variation);
            store(S(judge_command), s[i].command);
            store(S(judge_peak), s[i].peak);
            store(S(judge_below10), -__builtin_convertvector(s[i].below10, vec));
            store(S(judge_below90), -__builtin_convertvector(s[i].below90, vec));
            store(S(judge_outside), s[i].outside);
            store(S(judge_error), error[i]);
        }
    }
}
