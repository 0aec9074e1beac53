/* The estimate closes the loop; inverter and sensors are ideal, so what is left is the method, the floats and
 * the resolution of the PWM counter. */
#include "tests/rig/run.h"

void setUp(void)
{
}

void tearDown(void)
{
}

/* ---- points ---- */

typedef struct {
    const char *name;
    double pole_pairs, resistance, inductance, flux_linkage; /* [-], [ohm], [H], [Wb] */
    double inertia, friction, load;                          /* [kg m^2], [N m], [N m] */
    double speed;                                            /* [rad/s] largest, mechanical */
    double current, dc_voltage;                              /* [A] limit, [V] */
} motor_t;

/* The paper's Table I in its rig. */
static const motor_t paper = {"paper", 4.0, 0.95, 12.5e-3, 0.183, 0.0636, 1.32, 5.0, 1500.0 * RPM, 10.0, 311.0};

/* Fast and light: omega_e T_s = 0.3 with one pole pair, 28648 r/min. */
static const motor_t spindle = {"spindle", 1.0, 0.4, 0.6e-3, 0.03, 5e-5, 0.03, 0.3, 3000.0, 10.0, 250.0};

/* The same frequency from many poles; hardly any inductance. */
static const motor_t hub = {"hub", 15.0, 0.12, 0.35e-3, 0.015, 0.02, 0.3, 2.5, 200.0, 12.0, 120.0};

/* Slow, with much of everything. */
static const motor_t torque = {"torque", 20.0, 12.0, 60e-3, 0.55, 0.5, 3.0, 30.0, 13.0, 3.0, 400.0};

/* Resistance rules: R T_s/L = 0.4 (the observer's limit is 0.5). */
static const motor_t miniature = {"miniature", 2.0, 8.0, 2e-3, 0.02, 2e-5, 0.01, 0.06, 1000.0, 1.5, 100.0};

static void put_motor(rig_t *rig, const motor_t *m)
{
    const double emf = m->flux_linkage * m->pole_pairs * m->speed;
    const double gain = 1.75 * emf;
    const double slope = 1.6 * m->inductance / (gain * RIG_PERIOD_SECONDS);
    const double torque_per_ampere = 1.5 * m->pole_pairs * m->flux_linkage;
    const struct {
        const char *name;
        double value;
    } rows[] = {
        {"pole_pairs", m->pole_pairs},
        {"plant.resistance", m->resistance},
        {"plant.inductance_d", m->inductance},
        {"plant.inductance_q", m->inductance},
        {"plant.flux_linkage", m->flux_linkage},
        {"plant.inertia", m->inertia},
        {"friction_coulomb", m->friction},
        {"dc_voltage", m->dc_voltage},
        {"motor_pole_pairs", m->pole_pairs},
        {"motor_resistance", m->resistance},
        {"motor_inductance_d", m->inductance},
        {"motor_inductance_q", m->inductance},
        {"motor_flux_linkage", m->flux_linkage},
        {"motor_inertia", m->inertia},
        {"current_limit", m->current},
        {"overcurrent_trip", 1.5 * m->current},
        {"dc_overvoltage", 1.1 * m->dc_voltage},
        {"dc_undervoltage", 0.6 * m->dc_voltage},
        {"overspeed_trip", 1.15 * m->speed},
        {"start_speed", 0.05 * m->speed},
        {"estimate_speed_min", 0.02 * m->speed},
        /* bandwidth of the speed control 8 rad/s, its corner a quarter of that: as the paper's */
        {"speed_kp", 8.0 * m->inertia / torque_per_ampere},
        {"speed_ki", 16.0 * m->inertia / torque_per_ampere},
        {"observer_gain", gain},
        {"observer_slope", slope},
        /* the error at 96 % of k_s */
        {"estimate_current_max", 4.0 / slope},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        run_put(rig, rows[n].name, rows[n].value);
    }
}

/* A motor in the loop: as many rows changed as the case wants, then a point is driven to and measured. */
typedef struct {
    const char *name;
    double value;
} change_t;

static run_error_t measure(const motor_t *m, double fidelity, const change_t *changes, size_t count, double rpm,
                           double load)
{
    rig_t *rig = rig_create(7);
    TEST_ASSERT_NOT_NULL(rig);
    run_put(rig, "fidelity", fidelity);
    run_ideal(rig);
    put_motor(rig, m);
    for (size_t n = 0; n < count; n++) {
        run_put(rig, changes[n].name, changes[n].value);
    }
    run_parameter(rig, "position_source", 1.0);
    run_to_ready_at(rig, rpm);
    run_on(rig, rpm);
    run_seconds(rig, 0.3);
    if (load > 0.0) {
        run_load(rig, load, 1.5);
    }
    run_seconds(rig, 1.5);
    const run_error_t err = run_error(rig, 1.5);
    printf("%s %.0f r/min, %g N m: mean %.3f, SD %.3f, peak %.3f mrad, speed %.1f r/min\n", m->name, rpm, load,
           err.mean, err.sd, err.peak, err.speed_mean);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * fabs(rpm) + 0.5, rpm, err.speed_mean);
    rig_free(rig);
    return err;
}

static void probe(void){
 const motor_t *all[]={&paper,&spindle,&hub,&torque,&miniature};
 for(int f=1;f>=0;f--) for(size_t m=0;m<5;m++) for(int d=1;d>=-1;d-=2) for(int l=0;l<2;l++) for(int s=0;s<4;s++){
  static const double share[]={1/15.,1/3.,2/3.,1.};
  printf("%s ", f?"avg":"sw");
  measure(all[m],f,NULL,0,d*share[s]*all[m]->speed/RPM,l?all[m]->load:0.0);
 }
}
int main(void){ UNITY_BEGIN(); RUN_TEST(probe); return UNITY_END(); }
