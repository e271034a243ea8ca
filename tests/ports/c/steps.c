/* S10: the first steps of the augmented-Lagrangian methods and of the presets. */

#include "descent.h"
#include "stages.h"

static const char *const direction_names[] = {"gradient", "jacobi", "chebyshev", "cg",
                                              "lbfgs",    "newton", NULL};
static const char *const begin_names[] = {"last", "unit", "model", NULL};
static const char *const scaling_names[] = {"total-mass", "mean-inverse-mass", "scaled", NULL};
enum begin_kind { LAST, UNIT, MODEL };
enum scaling_kind { TOTAL_MASS, MEAN_INVERSE_MASS, SCALED };

struct settings {
    bool every_step, faithful;
    enum begin_kind begin;
    double first_step, grow, inner_accuracy, eps_x, eps_f, eps_g;
    size_t inner_steps, steps;
    struct search search;
};

/* What one evaluation of L finds. */
struct measures {
    double value;            /* L */
    double error;            /* sum g^2 / w, with g the gradient of L */
    double gradient_sq;      /* sum g^2 */
    double shift_sq;         /* sum of (change of l by an update / mu)^2 */
    double largest_gradient; /* largest |g| */
    double largest_pull;     /* largest |w x| */
};

/* Displacements in metres, with the objective of the system that a preset comes from. */
static void use_metres(struct descent *descent, enum scaling_kind scaling) {
    const struct zone *zone = descent->zone;
    double factor = 0;
    for (size_t i = 0; i < zone->n_vertices; ++i)
        if (!zone->pinned[i]) factor += 1.0 / zone->masses[i];
    factor = scaling == TOTAL_MASS ? 2 / zone->total_mass
                                   : factor / ((double)descent->n_unknown / 3);
    for (size_t i = 0; i < zone->n_vertices; ++i) {
        descent->lengths[i] = 1;
        for (size_t c = 3 * i; c < 3 * i + 3; ++c)
            descent->weights[c] = zone->pinned[i] ? 1 : (real)(factor * zone->masses[i]);
    }
    for (size_t j = 0; j < descent->m; ++j) {
        descent->metres[j] = 1;
        descent->starts[j] = zone->thickness - gap_of_impact(zone, j, zone->proposed);
        for (size_t e = 4 * j; e < 4 * j + 4; ++e)
            descent->coefficients[e] = zone->pinned[zone->nodes[e]] ? 0 : zone->weights[e];
    }
}

/* z = sqrt(m) (x - y) with rows of unit length, both in units of the largest |s|. */
static void use_scaled_variables(struct descent *descent) {
    const struct zone *zone = descent->zone;
    real unit = 0;
    for (size_t j = 0; j < descent->m; ++j) {
        real row_sq = 0;
        for (size_t e = 4 * j; e < 4 * j + 4; ++e) {
            size_t vertex = (size_t)zone->nodes[e];
            if (zone->pinned[vertex]) continue;
            descent->coefficients[e] = zone->weights[e] / root_of(zone->masses[vertex]);
            row_sq += descent->coefficients[e] * descent->coefficients[e];
        }
        real row = row_sq > 0 ? root_of(row_sq) * length(vec_at(zone->normals, j)) : 1;
        for (size_t e = 4 * j; e < 4 * j + 4; ++e) descent->coefficients[e] /= row;
        descent->metres[j] = row;
        descent->starts[j] = (zone->thickness - gap_of_impact(zone, j, zone->proposed)) / row;
        unit = larger(unit, magnitude(descent->starts[j]));
    }
    if (unit == 0) unit = 1; /* every gap is the thickness: any unit will do */
    for (size_t j = 0; j < descent->m; ++j) {
        descent->starts[j] /= unit;
        descent->metres[j] *= unit;
    }
    for (size_t i = 0; i < descent->n; ++i) descent->weights[i] = 1;
    for (size_t i = 0; i < zone->n_vertices; ++i)
        descent->lengths[i] = zone->pinned[i] ? 0 : unit / root_of(zone->masses[i]);
}

static struct descent begin_descent(const struct zone *zone, enum scaling_kind scaling) {
    size_t n = 3 * zone->n_vertices, m = zone->n_impacts;
    struct descent descent = {.zone = zone, .n = n, .m = m, .omega = 1};
    real **const of_coordinates[] = {
        &descent.weights,         &descent.x,               &descent.gradient, &descent.direction,
        &descent.gradient_before, &descent.gradient_change, &descent.x_before,
    };
    real **const of_impacts[] = {&descent.starts, &descent.metres, &descent.multipliers,
                                 &descent.constraints, &descent.pushed, &descent.rates};
    for (size_t i = 0; i < sizeof of_coordinates / sizeof *of_coordinates; ++i)
        *of_coordinates[i] = allocate_reals(n);
    for (size_t i = 0; i < sizeof of_impacts / sizeof *of_impacts; ++i)
        *of_impacts[i] = allocate_reals(m);
    descent.coefficients = allocate_reals(4 * m);
    descent.lengths = allocate_reals(zone->n_vertices);
    for (size_t i = 0; i < zone->n_vertices; ++i) descent.n_unknown += zone->pinned[i] ? 0 : 3;
    if (scaling == SCALED)
        use_scaled_variables(&descent);
    else
        use_metres(&descent, scaling);
    return descent;
}

static void evaluate_constraints(struct descent *descent) {
    constraint_products(descent, descent->x, descent->constraints);
    for (size_t j = 0; j < descent->m; ++j)
        descent->constraints[j] = descent->starts[j] - descent->constraints[j];
}

/* Computes `constraints`, `pushed` and `gradient` at x. */
static struct measures evaluate(struct descent *descent) {
    struct measures measures = {0, 0, 0, 0, 0, 0};
    double mu = descent->penalty;
    real *forces = allocate_reals(descent->m);
    evaluate_constraints(descent);
    for (size_t j = 0; j < descent->m; ++j) {
        real rest = descent->multipliers[j] / (real)mu, c = descent->constraints[j];
        descent->pushed[j] = c + rest;
        forces[j] = larger(descent->pushed[j], 0);
        double shift = smaller(-c, rest);
        measures.shift_sq += shift * shift;
        measures.value += 0.5 * mu * ((double)forces[j] * forces[j] - (double)rest * rest);
    }
    for (size_t i = 0; i < descent->n; ++i)
        descent->gradient[i] = descent->weights[i] * descent->x[i];
    add_pulls(descent, -(real)mu, forces, descent->gradient);
    for (size_t i = 0; i < descent->n; ++i) {
        double g = descent->gradient[i], w = descent->weights[i], pull = w * descent->x[i];
        measures.value += 0.5 * pull * descent->x[i];
        measures.gradient_sq += g * g;
        measures.error += g * g / w;
        measures.largest_gradient = fmax(measures.largest_gradient, fabs(g));
        measures.largest_pull = fmax(measures.largest_pull, fabs(pull));
    }
    return measures;
}

static void update(struct descent *descent) {
    evaluate_constraints(descent);
    for (size_t j = 0; j < descent->m; ++j) {
        real pushed = descent->multipliers[j] + (real)descent->penalty * descent->constraints[j];
        descent->multipliers[j] = larger(pushed, 0);
    }
}

/* Whether an inner solve, which minimises L with fixed multipliers, is done after a step that
   changed L by `change`. Without `faithful` it ends by criterion B of Rockafellar: L is within
   error / 2 of its minimum, because w is its least curvature. */
static bool is_inner_solve_done(const struct descent *descent, const struct settings *settings,
                                const struct measures *measures, size_t taken, double change) {
    if (taken >= settings->inner_steps) return true;
    double delta = settings->inner_accuracy;
    if (!settings->faithful)
        return measures->error <= delta * delta * descent->penalty * measures->shift_sq;
    const real *p = descent->direction;
    double step = descent->step_length * sqrt(sum_of_products(p, p, descent->n));
    double value = fmax(1, fmax(fabs(measures->value), fabs(measures->value - change)));
    return sqrt(measures->gradient_sq) <= settings->eps_g || step <= settings->eps_x ||
           -change <= settings->eps_f * value;
}

/* Chooses a direction and a step, and moves x. Returns false if the search finds no step. */
static bool take_step(struct descent *descent, struct settings *settings, double last, bool restart,
                      struct step *step_out) {
    struct line line = choose_direction(descent, restart);
    double first = 1;
    if (settings->begin == LAST)
        first = last * settings->grow;
    else if (settings->begin == MODEL || (descent->kind == LBFGS && descent->n_pairs == 0))
        first = -line.slope / second_derivative(&line);
    *step_out = search_line(&line, first, &settings->search);
    if (!(step_out->length > 0)) return false;
    descent->step_length = step_out->length;
    for (size_t i = 0; i < descent->n; ++i) {
        descent->gradient_before[i] = descent->gradient[i];
        descent->x[i] += (real)step_out->length * descent->direction[i];
    }
    if (descent->kind == CHEBYSHEV) accelerate(descent);
    return true;
}

/* The outputs after each step, and how many there are. */
struct trace {
    real *objectives, *violations, *step_sizes;
    size_t count;
};

static void record(const struct descent *descent, double step, struct trace *trace) {
    double objective = 0, violation = 0;
    for (size_t i = 0; i < descent->n; ++i) {
        double move = (double)descent->lengths[i / 3] * descent->x[i];
        objective += 0.5 * (double)descent->zone->masses[i / 3] * move * move;
    }
    for (size_t j = 0; j < descent->m; ++j)
        violation = fmax(violation, (double)descent->constraints[j] * descent->metres[j]);
    trace->objectives[trace->count] = (real)objective;
    trace->violations[trace->count] = (real)violation;
    trace->step_sizes[trace->count++] = (real)step;
}

static double largest_of(const real *values, size_t n) {
    double largest = 0;
    for (size_t i = 0; i < n; ++i) largest = fmax(largest, fabs((double)values[i]));
    return largest;
}

/* The order of the updates matters. The multipliers change after a move, and cg and lbfgs compare
   two gradients for the same multipliers: so for them the update waits for the next gradient. */
static void run(struct descent *descent, struct settings *settings, struct trace *trace) {
    bool has_memory = descent->kind == CG || descent->kind == LBFGS, moved = false, restart = true;
    size_t inner = 0; /* steps since the last inner solve ended */
    double last = settings->first_step, largest_start = largest_of(descent->starts, descent->m);
    struct step step = {0, 0};
    for (size_t taken = 0;; ++taken) {
        struct measures measures = evaluate(descent);
        if (taken > 0) record(descent, step.length, trace);
        if (taken == settings->steps) return;
        if (measures.error == 0 && measures.shift_sq == 0) return; /* this is the solution */
        if (moved && has_memory) remember_step(descent);
        bool done = !settings->every_step;
        if (done && moved)
            done = is_inner_solve_done(descent, settings, &measures, inner, step.change);
        if (taken > 0 && (done || (settings->every_step && has_memory))) {
            update(descent);
            measures = evaluate(descent);
            inner = 0;
            restart = restart || done;
        }
        if (settings->faithful && inner == 0 && sqrt(measures.gradient_sq) <= settings->eps_g)
            return; /* an inner solve that takes no step is the last one */
        /* A gradient this small is rounding. It counts as a step, and the multipliers go on. */
        double noise = measures.largest_pull + descent->penalty * largest_start;
        moved = measures.largest_gradient > 0.5 * EPSILON * noise;
        step = (struct step){0, 0};
        if (moved) {
            moved = take_step(descent, settings, last, restart, &step);
            if (!moved && settings->faithful) return;
            if (moved) last = step.length;
            restart = false;
        }
        if (!moved && !settings->faithful) {
            last = settings->first_step;
            restart = true;
        }
        if (settings->every_step && !has_memory) update(descent);
        ++inner;
    }
}

static size_t read_count(const struct json *input, const char *name) {
    return (size_t)read_integer(input, name, 0, 1000000);
}

static struct settings read_settings(const struct json *input) {
    struct settings settings = {.search = read_search(input)};
    settings.every_step = read_integer(input, "every_step", 0, 1);
    settings.faithful = read_integer(input, "faithful", 0, 1);
    settings.begin = (enum begin_kind)read_choice(input, "begin", begin_names);
    settings.first_step = read_positive(input, "first_step");
    settings.grow = read_positive(input, "grow");
    settings.inner_accuracy = read_real(input, "inner_accuracy");
    settings.eps_x = read_real(input, "eps_x");
    settings.eps_f = read_real(input, "eps_f");
    settings.eps_g = read_real(input, "eps_g");
    settings.inner_steps = read_count(input, "inner_steps");
    settings.steps = read_count(input, "steps");
    return settings;
}

void first_iterations(const struct json *input) {
    struct zone zone = read_zone(input);
    struct settings settings = read_settings(input);
    size_t scaling = read_choice(input, "scaling", scaling_names);
    struct descent descent = begin_descent(&zone, (enum scaling_kind)scaling);
    descent.kind = (enum direction_kind)read_choice(input, "direction_name", direction_names);
    descent.preconditioned = read_integer(input, "preconditioned", 0, 1);
    descent.penalty = read_positive(input, "penalty");
    descent.pairs = (size_t)read_integer(input, "pairs", 1, MOST_PAIRS);
    descent.delay = read_count(input, "delay");
    descent.rho = read_real(input, "rho");
    descent.linear_tolerance = read_real(input, "linear_tolerance");
    struct trace trace = {allocate_reals(settings.steps), allocate_reals(settings.steps),
                          allocate_reals(settings.steps), 0};
    run(&descent, &settings, &trace);
    real *positions = allocate_reals(descent.n);
    for (size_t i = 0; i < descent.n; ++i)
        positions[i] = zone.proposed[i] + descent.lengths[i / 3] * descent.x[i];
    write_reals("objectives", trace.objectives, trace.count);
    write_reals("violations", trace.violations, trace.count);
    write_reals("step_sizes", trace.step_sizes, trace.count);
    write_reals("positions", positions, descent.n);
}
