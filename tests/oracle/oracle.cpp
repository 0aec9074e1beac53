#include "tests/oracle/oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/oracle/exponential.h"
#include <unsupported/Eigen/MatrixFunctions>

Matrix9 oracle_exponential(const Matrix9 &matrix)
{
    return matrix.exp();
}

namespace
{

constexpr double tick_seconds = 1.0 / 150e6;
constexpr double pi = 3.14159265358979323846;

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

struct Effective {
    uint64_t tick;
    unsigned gate;
    bool on;
};

/* The command edges with their delays. Each gate has its own delay line; an edge that is overtaken by the
 * next one is cancelled together with it. */
std::vector<Effective> delayed(const plant_params_t &q, const oracle_edge_t *edges, size_t count)
{
    const auto on_ticks = static_cast<uint64_t>(std::llround(q.turn_on_delay / tick_seconds));
    const auto off_ticks = static_cast<uint64_t>(std::llround(q.turn_off_delay / tick_seconds));
    std::vector<Effective> all;
    for (unsigned gate = 0; gate < 6; gate++) {
        std::vector<Effective> line;
        bool level = false;
        for (size_t n = 0; n < count; n++) {
            const bool wanted = (edges[n].on >> gate & 1u) != 0;
            if (wanted == level) {
                continue;
            }
            level = wanted;
            const uint64_t acts = edges[n].tick + (level ? on_ticks : off_ticks);
            if (!line.empty() && acts <= line.back().tick) {
                line.pop_back();
            } else {
                line.push_back({acts, gate, level});
            }
        }
        all.insert(all.end(), line.begin(), line.end());
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Effective &x, const Effective &y) { return x.tick < y.tick; });
    return all;
}

class Machine
{
  public:
    Machine(const plant_params_t &params, oracle_frame_t frame_kind, double theta_m, double omega_m)
        : q(params), frame(frame_kind), p(params.pole_pairs), theta(params.pole_pairs * theta_m),
          omega(omega_m)
    {
        inductance << q.inductance_d, 0.0, 0.0, q.inductance_q;
        const double least = std::min(q.inductance_d, q.inductance_q);
        zone = std::max(q.current_zone, (0.5 * q.dc_voltage + q.diode_voltage) * 1e-6 / least);
        if (q.shaft_locked != 0.0) {
            omega = q.shaft_locked_speed;
        }
    }

    void gate(unsigned number, bool on)
    {
        if (on) {
            gates |= 1u << number;
        } else {
            gates &= ~(1u << number);
        }
        if (gates != 0) {
            floating = false;
        }
    }

    void advance(double seconds)
    {
        while (seconds > 0.0) {
            const double longest = frame == ORACLE_ROTOR  ? ORACLE_STEP_ROTOR
                                   : frame == ORACLE_FLUX ? ORACLE_STEP_FLUX
                                                          : ORACLE_STEP;
            const double h = std::min(seconds, longest);
            seconds = seconds - h < 1e-15 ? 0.0 : seconds - h;
            substep(h);
        }
    }

    oracle_sample_t sample() const
    {
        const std::array<double, 3> i = phases(current);
        return {i[0], i[1], i[2], theta / p, omega, torque()};
    }

  private:
    enum Region { below, inside, above };

    static Matrix2 turn(double angle)
    {
        return Eigen::Rotation2Dd(angle).toRotationMatrix();
    }

    static std::array<double, 3> phases(const Vector2 &i)
    {
        std::array<double, 3> out{};
        for (int n = 0; n < 3; n++) {
            const double axis = 2.0 * pi * n / 3.0;
            out[static_cast<size_t>(n)] = i.x() * std::cos(axis) + i.y() * std::sin(axis);
        }
        return out;
    }

    /* The leg voltage a - r i in one region. */
    void leg(unsigned number, Region region, double &a, double &r) const
    {
        const unsigned pair = gates >> (2 * number) & 3u;
        double a_plus = 0.0, r_plus = 0.0, a_minus = 0.0, r_minus = 0.0;
        switch (pair) {
        case 0:
            a_plus = -q.diode_voltage;
            r_plus = r_minus = q.diode_resistance;
            a_minus = q.dc_voltage + q.diode_voltage;
            break;
        case 1:
            a_plus = q.dc_voltage - q.igbt_voltage;
            r_plus = q.igbt_resistance;
            a_minus = q.dc_voltage + q.diode_voltage;
            r_minus = q.diode_resistance;
            break;
        case 2:
            a_plus = -q.diode_voltage;
            r_plus = q.diode_resistance;
            a_minus = q.igbt_voltage;
            r_minus = q.igbt_resistance;
            break;
        default:
            a_plus = a_minus = 0.5 * q.dc_voltage;
            break;
        }
        if (region == above) {
            a = a_plus;
            r = r_plus;
        } else if (region == below) {
            a = a_minus;
            r = r_minus;
        } else {
            const double v_plus = a_plus - r_plus * zone;
            const double v_minus = a_minus + r_minus * zone;
            a = 0.5 * (v_plus + v_minus);
            r = (v_minus - v_plus) / (2.0 * zone);
        }
    }

    /* The EMF in the stationary frame: minus the derivative of the flux of the magnets; for phase a -omega
     * psi (sin + k5 sin 5 + k7 sin 7). */
    Vector2 emf(double omega_e) const
    {
        Vector2 e = Vector2::Zero();
        for (int n = 0; n < 3; n++) {
            const double axis = 2.0 * pi * n / 3.0;
            const double x = theta - axis;
            const double phase =
                -omega_e * q.flux_linkage *
                (std::sin(x) + q.emf_5th * std::sin(5.0 * x) + q.emf_7th * std::sin(7.0 * x));
            e += 2.0 / 3.0 * phase * Vector2(std::cos(axis), std::sin(axis));
        }
        return e;
    }

    /* The currents that make the flux: the phase currents less omega psi/R_c along the EMF, at the speed
     * at which they were computed. */
    Vector2 inner(const Vector2 &i) const
    {
        Vector2 o = i;
        for (int pass = 0; q.iron_loss_resistance > 0.0 && pass < 60; pass++) {
            const Vector2 psi = linkage(o);
            o = i - made_at / q.iron_loss_resistance * Vector2(-psi.y(), psi.x());
        }
        return o;
    }

    double torque() const
    {
        Vector2 i = turn(-theta) * current;
        if (frame == ORACLE_FLUX) {
            i = inner(i);
            const Vector2 psi = linkage(i);
            return 1.5 * p * (psi.x() * i.y() - psi.y() * i.x());
        }
        return 1.5 * p * (q.inductance_d - q.inductance_q) * i.x() * i.y() + 1.5 * p * emf(1.0).dot(current);
    }

    /* The flux linkage of the windings in the rotor frame at these currents; the second function returns
     * the currents at this linkage. */
    Vector2 linkage(const Vector2 &i) const
    {
        const auto along = [](double inductance_0, double limit, double x) {
            return limit > 0.0 ? inductance_0 * x / std::hypot(1.0, x / limit) : inductance_0 * x;
        };
        return Vector2(q.flux_linkage + along(q.inductance_d, q.saturation_d, i.x()),
                       along(q.inductance_q, q.saturation_q, i.y()));
    }

    Vector2 linked(const Vector2 &psi) const
    {
        const auto back = [](double inductance_0, double limit, double x) {
            const double i = x / inductance_0;
            return limit > 0.0 ? i / std::sqrt((1.0 - i / limit) * (1.0 + i / limit)) : i;
        };
        return Vector2(back(q.inductance_d, q.saturation_d, psi.x() - q.flux_linkage),
                       back(q.inductance_q, q.saturation_q, psi.y()));
    }

    /* The currents after the time h, by psi' = source - resistance i in the stationary frame. */
    Vector2 solve_flux(double h, double omega_e, const Vector2 &source, const Matrix2 &resistance) const
    {
        const auto currents = [&](const Vector2 &psi, double ahead) {
            const double angle = theta + omega_e * ahead;
            const double g = q.iron_loss_resistance > 0.0 ? omega_e / q.iron_loss_resistance : 0.0;
            return Vector2(turn(angle) * linked(turn(-angle) * psi) + g * Vector2(-psi.y(), psi.x()));
        };
        const auto slope = [&](const Vector2 &psi, double ahead) {
            return Vector2(source - resistance * currents(psi, ahead));
        };
        const Vector2 psi = turn(theta) * linkage(inner(turn(-theta) * current));
        const Vector2 k1 = slope(psi, 0.0);
        const Vector2 k2 = slope(psi + 0.5 * h * k1, 0.5 * h);
        const Vector2 k3 = slope(psi + 0.5 * h * k2, 0.5 * h);
        const Vector2 k4 = slope(psi + h * k3, h);
        return currents(psi + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), h);
    }

    double resisting(double speed) const
    {
        const bool passive = q.load_kind == PLANT_LOAD_PASSIVE;
        const double dry = q.friction_coulomb + (passive ? q.load_torque : 0.0);
        const double width = std::max(0.2, 2e-4 * dry / q.inertia);
        const double x = std::clamp(speed / width, -1.0, 1.0);
        return dry * x * (3.0 - x * x) / 2.0 + q.friction_viscous * speed + (passive ? 0.0 : q.load_torque);
    }

    /* The currents (stationary frame) after the time h, with the legs in these regions. */
    Vector2 solve(double h, double omega_e, const std::array<Region, 3> &region) const
    {
        Vector2 source = Vector2::Zero();
        Matrix2 resistance = q.resistance * Matrix2::Identity();
        for (unsigned n = 0; n < 3; n++) {
            const Vector2 axis(std::cos(2.0 * pi * n / 3.0), std::sin(2.0 * pi * n / 3.0));
            double a = 0.0, r = 0.0;
            leg(n, region[n], a, r);
            source += 2.0 / 3.0 * a * axis;
            resistance += 2.0 / 3.0 * r * axis * axis.transpose();
        }
        if (frame == ORACLE_FLUX) {
            return solve_flux(h, omega_e, source, resistance);
        }
        Matrix2 quarter;
        quarter << 0.0, -1.0, 1.0, 0.0;
        Matrix9 system = Matrix9::Zero();
        Vector9 state = Vector9::Zero();
        state(8) = 1.0;
        if (frame == ORACLE_STATIONARY) {
            const double inverse = 1.0 / q.inductance_d;
            state.segment<2>(0) = current;
            const double order[3] = {1.0, -5.0, 7.0};
            const double size[3] = {1.0, -q.emf_5th, q.emf_7th};
            for (int k = 0; k < 3; k++) {
                /* the derivative is j omega psi e^(j n theta) */
                state.segment<2>(2 + 2 * k) =
                    omega_e * q.flux_linkage * size[k] * (turn(order[k] * theta) * Vector2(0.0, 1.0));
                system.block<2, 2>(2 + 2 * k, 2 + 2 * k) = order[k] * omega_e * quarter;
                system.block<2, 2>(0, 2 + 2 * k) = -inverse * Matrix2::Identity();
            }
            system.block<2, 2>(0, 0) = -inverse * resistance;
            system.block<2, 1>(0, 8) = inverse * source;
            const Vector9 end = oracle_exponential(system * h) * state;
            return end.segment<2>(0);
        }
        const Matrix2 inverse = inductance.inverse();
        const Matrix2 middle = turn(theta + 0.5 * omega_e * h);
        state.segment<2>(0) = turn(-theta) * current;
        state.segment<2>(2) = turn(-theta) * source;
        state.segment<2>(4) = Vector2(std::cos(6.0 * theta), std::sin(6.0 * theta));
        system.block<2, 2>(0, 0) =
            -inverse * (middle.transpose() * resistance * middle + omega_e * quarter * inductance);
        system.block<2, 2>(0, 2) = inverse;
        system.block<2, 2>(2, 2) = -omega_e * quarter;
        system.block<2, 2>(4, 4) = 6.0 * omega_e * quarter;
        Matrix2 harmonic;
        harmonic << 0.0, -(q.emf_5th + q.emf_7th), q.emf_7th - q.emf_5th, 0.0;
        system.block<2, 2>(0, 4) = -omega_e * q.flux_linkage * inverse * harmonic;
        system.block<2, 1>(0, 8) = -omega_e * q.flux_linkage * inverse * Vector2(0.0, 1.0);
        const Vector9 end = oracle_exponential(system * h) * state;
        return turn(theta + omega_e * h) * end.segment<2>(0);
    }

    /* By how much a current is past a border of its region; positive values are outside. */
    double beyond(const Vector2 &i, const std::array<Region, 3> &region) const
    {
        const std::array<double, 3> phase = phases(i);
        double most = -1e9;
        for (size_t n = 0; n < 3; n++) {
            const double x = phase[n];
            const double past = region[n] == above   ? zone - x
                                : region[n] == below ? x + zone
                                                     : std::fabs(x) - zone;
            most = std::max(most, past);
        }
        return most;
    }

    void substep(double h)
    {
        const double torque_0 = torque();
        const bool locked = q.shaft_locked != 0.0;
        const double speed = locked ? omega : omega + 0.5 * h * (torque_0 - resisting(omega)) / q.inertia;
        const double omega_e = p * speed;
        double left = h;
        made_at = floating ? omega_e : made_at;
        while (left > 0.0 && !floating) {
            /* A current on a border belongs to the region into which it moves: its value a short time
             * later, computed with the nearer region, decides. */
            std::array<Region, 3> region{};
            const std::array<double, 3> now = phases(current);
            for (size_t n = 0; n < 3; n++) {
                region[n] = now[n] > zone ? above : now[n] < -zone ? below : inside;
            }
            const double ahead = std::min(left, 1e-9);
            const std::array<double, 3> soon = phases(solve(ahead, omega_e, region));
            for (size_t n = 0; n < 3; n++) {
                region[n] = soon[n] > zone ? above : soon[n] < -zone ? below : inside;
            }
            double part = left;
            Vector2 end = solve(part, omega_e, region);
            if (beyond(end, region) > 1e-9 && left > ahead) {
                double low = ahead, high = left;
                for (int n = 0; n < 60 && high - low > 1e-13; n++) {
                    const double middle = 0.5 * (low + high);
                    (beyond(solve(middle, omega_e, region), region) > 0.0 ? high : low) = middle;
                }
                part = high;
                end = solve(part, omega_e, region);
            }
            current = end;
            made_at = omega_e;
            theta += omega_e * part;
            left -= part;
        }
        if (floating) {
            theta += omega_e * left;
        }
        if (!locked) {
            omega += h * (0.5 * (torque_0 + torque()) - resisting(speed)) / q.inertia;
        }
        rest(h);
    }

    /* Applies the rule for floating legs. */
    void rest(double h)
    {
        const Vector2 e = emf(p * omega);
        const std::array<double, 3> e_phase = phases(e);
        const auto ends = std::minmax_element(e_phase.begin(), e_phase.end());
        const bool low_emf = *ends.second - *ends.first < q.dc_voltage + 2.0 * q.diode_voltage;
        const std::array<double, 3> i = phases(current);
        const bool quiet =
            gates == 0 && std::fabs(i[0]) < zone && std::fabs(i[1]) < zone && std::fabs(i[2]) < zone;
        calm = quiet ? calm + h : 0.0;
        if (floating) {
            floating = low_emf;
        } else if (calm >= 50e-6 && low_emf) {
            floating = true;
            current.setZero();
        }
    }

    const plant_params_t q;
    const oracle_frame_t frame;
    const double p;
    Matrix2 inductance;
    double zone = 0.0;
    double theta;
    double omega;
    Vector2 current = Vector2::Zero();
    double made_at = 0.0; /* [rad/s] electrical speed at which `current` was computed */
    unsigned gates = 0;
    bool floating = true;
    double calm = 0.0;
};

} // namespace

bool oracle_run(const plant_params_t *params, oracle_frame_t frame, double theta_m, double omega_m,
                const oracle_edge_t *edges, size_t edge_count, const uint64_t *sample_ticks,
                size_t sample_count, oracle_sample_t *samples)
{
    const bool soft = params->dc_resistance > 0.0 && params->dc_capacitance > 0.0;
    const bool broken =
        params->open_phase_a != 0.0 || params->open_phase_b != 0.0 || params->open_phase_c != 0.0;
    /* The oracle does not contain individual legs, single switches, wires, ripple and a second mass; their
     * tests use algebra. */
    const double unknown[] = {params->leg_a_drop,       params->leg_b_drop,       params->leg_c_drop,
                              params->leg_a_resistance, params->leg_b_resistance, params->leg_c_resistance,
                              params->leg_a_delay,      params->leg_b_delay,      params->leg_c_delay,
                              params->open_switches,    params->swap_phases,      params->shorted_switches,
                              params->dc_ripple,        params->supply_lost,      params->load_inertia};
    for (const double row : unknown) {
        if (row != 0.0) {
            return false;
        }
    }
    const bool salient = std::fabs(params->inductance_d - params->inductance_q) > 0.0;
    const bool saturates = params->saturation_d > 0.0 || params->saturation_q > 0.0;
    const bool shaped = std::fabs(params->emf_5th) + std::fabs(params->emf_7th) > 0.0;
    if (frame == ORACLE_FLUX ? shaped : saturates) {
        return false;
    }
    if (soft || broken || params->force_fault != 0.0 || (frame == ORACLE_STATIONARY && salient)) {
        return false;
    }
    Machine machine(*params, frame, theta_m, omega_m);
    const std::vector<Effective> acts = delayed(*params, edges, edge_count);
    uint64_t now = 0;
    size_t next = 0;
    for (size_t n = 0; n < sample_count; n++) {
        while (next < acts.size() && acts[next].tick <= sample_ticks[n]) {
            machine.advance(static_cast<double>(acts[next].tick - now) * tick_seconds);
            now = acts[next].tick;
            machine.gate(acts[next].gate, acts[next].on);
            next++;
        }
        machine.advance(static_cast<double>(sample_ticks[n] - now) * tick_seconds);
        now = sample_ticks[n];
        samples[n] = machine.sample();
    }
    return true;
}
