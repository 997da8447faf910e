"""The QP of the MPC on the target: a dual active-set method, as C.

    minimise the distance of A u from T theta in the metric of G, so that low <= A u <= high,

in the multipliers of the active bounds, which are added one at a time, the most violated first, and
dropped where a step would turn their sign: Goldfarb & Idnani, Mathematical Programming 27 (1983) 1, doi
10.1007/BF02591962, in the form of Arnstrom, Bemporad & Axehill, IEEE Trans. Automatic Control 67 (2022)
4362.  The Gram matrix of the active set is factorised anew in each iteration, by LDL': with some ten bounds
active that costs less than the bookkeeping of updates would be worth.

CasADi's qrqp, which also makes C without allocation, was tried first: of 200 QPs of the fast setting
(condition of the Hessian 3600) it gave up on 75.  The osqp of cvxpy makes C with global state.
"""

SOLVER = r"""
/* Least distance in the multipliers of the active bounds; u0 is the first move. 0: found. */
static int solve(const double *theta, double least, double most, double was, double *u0)
{
    double at[ROWS], sum[ACTIVE], want[ACTIVE], old[ACTIVE], L[ACTIVE * ACTIVE];
    int rows[ACTIVE], sign[ACTIVE], in[ROWS];
    int count = 0, round, i, j, k;

    if (!(least <= most)) {
        return 1;
    }
    for (i = 0; i < ROWS; i++) {
        at[i] = T[i][0] * theta[0] + T[i][1] * theta[1] + T[i][2] * theta[2] + T[i][3] * theta[3];
        in[i] = 0;
    }
    for (round = 0; round < ROUNDS; round++) {
        int drop = -1, singular = 0, worst = -1, up = 0;
        double step = 1.0, most_off = 1e-9;

        /* LDL' of the Gram matrix of the active rows, D on the diagonal of L. */
        for (i = 0; i < count && !singular; i++) {
            for (j = 0; j <= i; j++) {
                double value = sign[i] * sign[j] * G[rows[i]][rows[j]];
                for (k = 0; k < j; k++) {
                    value -= L[i * ACTIVE + k] * L[j * ACTIVE + k] * L[k * ACTIVE + k];
                }
                L[i * ACTIVE + j] = j < i ? value / L[j * ACTIVE + j] : value;
            }
            singular = L[i * ACTIVE + i] <= 1e-11 * G[rows[i]][rows[i]];
        }
        if (singular && i < count) {
            return 1; /* only the row that was added last can depend on the others */
        }
        if (singular) {
            /* The direction in which the rows add up to nothing: of the last by as much as of the others. */
            for (i = 0; i < count - 1; i++) {
                want[i] = -L[(count - 1) * ACTIVE + i];
            }
            want[count - 1] = 1.0;
            for (i = count - 2; i >= 0; i--) {
                for (k = i + 1; k < count - 1; k++) {
                    want[i] -= L[k * ACTIVE + i] * want[k];
                }
            }
            step = INFINITY;
            for (i = 0; i < count; i++) {
                if (want[i] < -1e-12 && old[i] < -step * want[i]) {
                    step = -old[i] / want[i];
                    drop = i;
                }
            }
            if (drop < 0) {
                return 1; /* no u is within the bounds */
            }
            for (i = 0; i < count; i++) {
                old[i] += step * want[i];
            }
        } else {
            for (i = 0; i < count; i++) {
                double bound = sign[i] > 0 ? HIGH(rows[i]) : LOW(rows[i]);
                sum[i] = sign[i] * (at[rows[i]] - bound);
                for (k = 0; k < i; k++) {
                    sum[i] -= L[i * ACTIVE + k] * sum[k];
                }
            }
            for (i = count - 1; i >= 0; i--) {
                want[i] = sum[i] / L[i * ACTIVE + i];
                for (k = i + 1; k < count; k++) {
                    want[i] -= L[k * ACTIVE + i] * want[k];
                }
            }
            for (i = 0; i < count; i++) {
                if (want[i] < 0.0 && old[i] <= step * (old[i] - want[i])) {
                    step = old[i] / (old[i] - want[i]);
                    drop = i;
                }
            }
            for (i = 0; i < count; i++) {
                old[i] += step * (want[i] - old[i]);
            }
        }
        if (drop >= 0) {
            in[rows[drop]] = 0;
            count--;
            for (i = drop; i < count; i++) {
                rows[i] = rows[i + 1];
                sign[i] = sign[i + 1];
                old[i] = old[i + 1];
            }
            continue;
        }
        for (i = 0; i < ROWS; i++) {
            double value = at[i];
            if (in[i]) {
                continue;
            }
            for (k = 0; k < count; k++) {
                value -= G[i][rows[k]] * sign[k] * old[k];
            }
            if (value - HIGH(i) > most_off) {
                most_off = value - HIGH(i);
                worst = i;
                up = 1;
            }
            if (LOW(i) - value > most_off) {
                most_off = LOW(i) - value;
                worst = i;
                up = -1;
            }
        }
        if (worst < 0) {
            *u0 = at[0];
            for (k = 0; k < count; k++) {
                *u0 -= G[0][rows[k]] * sign[k] * old[k];
            }
            return 0;
        }
        if (count == ACTIVE) {
            return 1;
        }
        in[worst] = 1;
        rows[count] = worst;
        sign[count] = up;
        old[count] = 0.0;
        count++;
    }
    return 1;
}
"""
