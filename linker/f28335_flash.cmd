/* Linker command file for an image in the flash of the F28335 (data manual SPRS439, EABI section names). All numbers count 16-bit
 *words.
 *
 * The functions of the interrupt, and those that set the flash's wait states, are loaded into flash and run from L0-L3,
 * the program RAM without wait states; hal_boot copies them. Sectors C and B, 0x328000-0x337FFF, are kept for stored parameters: an
 * erase takes a whole sector, so nothing of the program may lie there. Sector A holds nothing but the entry, so that its other
 * special words stay erased: 0x33FF80-0x33FFF5, which belong to the code security module, and its password,
 * 0x33FFF8-0x33FFFF. */
MEMORY
{
    M0_M1      : origin = 0x000050, length = 0x0007B0 /* The boot ROM uses the words below this address for its stack and data. */
    L0_L3      : origin = 0x008000, length = 0x004000
    L4_L7      : origin = 0x00C000, length = 0x004000
    FLASH_H_D  : origin = 0x300000, length = 0x028000
    ENTRY      : origin = 0x33FFF6, length = 0x000002
    FPU_TABLES : origin = 0x3FEBDC, length = 0x0006A0 /* boot ROM */
    RESET      : origin = 0x3FFFC0, length = 0x000002 /* boot ROM */
}

SECTIONS
{
    codestart     : > ENTRY
    .text         : > FLASH_H_D
    .cinit        : > FLASH_H_D
    .init_array   : > FLASH_H_D
    .switch       : > FLASH_H_D
    .const        : > FLASH_H_D

    /* The functions that the interrupt calls, each in a section of its own (--gen_func_subsections), and the division of the fast
     * library. */
    .TI.ramfunc   : { *(.TI.ramfunc) -l rts2800_fpu32_fast_supplement_eabi.lib(.text)
                      /* begin: written by tools/check-linker --write */
                      /* firmware/app/app.c */
                      *(.text:app_interrupt) *(.text:app_read) *(.text:app_trip) *(.text:app_write) *(.text:compare_of)
                      *(.text:convert) *(.text:current_of) *(.text:daq_sample) *(.text:drive_flags) *(.text:drive_took)
                      *(.text:pack)
                      /* firmware/contract/capture.c */
                      *(.text:begin) *(.text:capture_reset) *(.text:capture_step) *(.text:capture_trigger)
                      *(.text:float_of_bits) *(.text:follow) *(.text:is_edge) *(.text:tap_slot_at) *(.text:value_of)
                      *(.text:watch)
                      /* firmware/drive/drive.c */
                      *(.text:drive_idle_tuning) *(.text:drive_step) *(.text:fast_bridge_on) *(.text:float_bits)
                      *(.text:orders_of) *(.text:turn_window)
                      /* firmware/estimator/encoder.c */
                      *(.text:bounds_magnitude) *(.text:encoder_phase)
                      /* firmware/estimator/estimator.c */
                      *(.text:angle_turn_back) *(.text:angle_wrap) *(.text:at_rest) *(.text:bounds_clamp)
                      *(.text:bounds_less) *(.text:bounds_more) *(.text:estimator_coast) *(.text:estimator_observe)
                      *(.text:estimator_track) *(.text:frames_park) *(.text:inverse_root) *(.text:lag_impedance)
                      *(.text:lag_undone) *(.text:lowpass_step) *(.text:observer_step) *(.text:one_period)
                      *(.text:pll_filtered) *(.text:pll_is_emf) *(.text:pll_soft_sign) *(.text:pll_step_inline)
                      *(.text:pll_turn) *(.text:rested) *(.text:saturation_at) *(.text:saturation_is_on)
                      *(.text:show_observer) *(.text:show_tracker) *(.text:shown) *(.text:smo_predict)
                      *(.text:smo_switch_vector) *(.text:smo_vector_gain) *(.text:tanh_ratio) *(.text:tracker_acceleration)
                      *(.text:tracker_coast) *(.text:tracker_cross) *(.text:tracker_flux) *(.text:tracker_is_salient)
                      *(.text:tracker_step) *(.text:tracker_straighten) *(.text:tracker_watch) *(.text:trig_turn)
                      /* firmware/estimator/lag.c */
                      *(.text:conductance_of) *(.text:filter_of) *(.text:lag_angle) *(.text:lag_emf) *(.text:over)
                      *(.text:speed_within) *(.text:square_of) *(.text:times) *(.text:undoing)
                      /* firmware/estimator/paper/lag_paper.c */
                      *(.text:frames_inverse_park)
                      /* firmware/estimator/pll.c */
                      *(.text:bounds_within) *(.text:pll_watch)
                      /* firmware/estimator/smo.c */
                      *(.text:smo_answer) *(.text:smo_equivalent_gain) *(.text:smo_error_square) *(.text:switch_any)
                      *(.text:switch_axes)
                      /* firmware/estimator/tracker.c */
                      *(.text:debounce_reset) *(.text:validity_reset)
                      /* firmware/estimator/tracker_salient.c */
                      *(.text:bend) *(.text:bounds_between) *(.text:share_of) *(.text:tracker_follow)
                      *(.text:tracker_reciprocal) *(.text:tracker_transient)
                      /* firmware/fast/control/current_control.c */
                      *(.text:current_control_reset)
                      /* firmware/fast/fast.c */
                      *(.text:begin_estimate) *(.text:begin_window) *(.text:bounds_span) *(.text:chopper_step)
                      *(.text:comes_on) *(.text:control) *(.text:current_control_applied) *(.text:current_control_shift)
                      *(.text:current_control_step) *(.text:current_control_take) *(.text:current_control_turn)
                      *(.text:dead_time_leg) *(.text:dead_time_passage) *(.text:dead_time_signs) *(.text:dead_time_voltage)
                      *(.text:demand) *(.text:doubt_may_be) *(.text:doubt_small) *(.text:doubt_step) *(.text:drive_outputs)
                      *(.text:edges_apart) *(.text:edges_sign) *(.text:edges_signs) *(.text:encoder_step) *(.text:estimate)
                      *(.text:estimate_load) *(.text:estimate_position) *(.text:estimator_set_flux)
                      *(.text:estimator_set_lean) *(.text:estimator_set_load) *(.text:estimator_take)
                      *(.text:fast_find_gates_on) *(.text:fast_moments) *(.text:fast_step) *(.text:fast_trip)
                      *(.text:fast_trip_input) *(.text:fast_turn) *(.text:fast_update_rotor) *(.text:fault_set_any)
                      *(.text:forced_advance) *(.text:frames_between) *(.text:frames_clarke) *(.text:frames_inverse_clarke)
                      *(.text:guard_background_stalled) *(.text:guard_bad_sample) *(.text:guard_brake_torque)
                      *(.text:guard_chopper_no_effect) *(.text:guard_chopper_overload) *(.text:guard_current_gain)
                      *(.text:guard_current_stuck) *(.text:guard_current_sum) *(.text:guard_dc_limits)
                      *(.text:guard_dc_ripple) *(.text:guard_derating) *(.text:guard_encoder_direction)
                      *(.text:guard_encoder_error) *(.text:guard_encoder_jump) *(.text:guard_encoder_lost)
                      *(.text:guard_encoder_mismatch) *(.text:guard_estimate_amplitude) *(.text:guard_estimate_current)
                      *(.text:guard_estimate_detector) *(.text:guard_estimate_speed) *(.text:guard_is_calm)
                      *(.text:guard_late) *(.text:guard_lock_lost) *(.text:guard_loop_slow) *(.text:guard_master_silent)
                      *(.text:guard_medium_late) *(.text:guard_module_overload) *(.text:guard_motor_overload)
                      *(.text:guard_motor_temperature) *(.text:guard_oscillation) *(.text:guard_params_corrupt)
                      *(.text:guard_phase_current) *(.text:guard_phase_loss) *(.text:guard_program_corrupt)
                      *(.text:guard_rotor_too_fast) *(.text:guard_runaway) *(.text:guard_sink_temperature)
                      *(.text:guard_speed) *(.text:guard_speed_error) *(.text:guard_stack_low) *(.text:guard_stalled)
                      *(.text:guard_start_stalled) *(.text:guard_start_unlocked) *(.text:guard_tripped) *(.text:guard_u_dc)
                      *(.text:guard_unlocked) *(.text:inverter_acted) *(.text:inverter_make) *(.text:inverter_remember)
                      *(.text:inverter_whole_counts) *(.text:limit) *(.text:limit_by_link) *(.text:limited_reference)
                      *(.text:link_limit_is_near) *(.text:loop_lean) *(.text:measure_current_flows) *(.text:measure_is_good)
                      *(.text:measure_late) *(.text:measure_step) *(.text:measure_take) *(.text:observer_take)
                      *(.text:permitted) *(.text:pi_output) *(.text:pi_take) *(.text:pi_update) *(.text:pll_take)
                      *(.text:reference_advance) *(.text:reference_in_rotor) *(.text:reference_rotor) *(.text:reference_run)
                      *(.text:reference_run_on_estimate) *(.text:reference_speed) *(.text:reference_stationary)
                      *(.text:reference_step) *(.text:reference_tracks) *(.text:run) *(.text:set_models) *(.text:smo_take)
                      *(.text:still_watch_count) *(.text:still_watch_one) *(.text:still_watch_remember) *(.text:sum_up)
                      *(.text:svpwm_modulate) *(.text:tracker_set_flux) *(.text:tracker_set_lean) *(.text:tracker_take)
                      *(.text:trig_advance) *(.text:validity_take) *(.text:voltage_uncertain)
                      /* firmware/fast/fast_trips.c */
                      *(.text:encoder_jumped) *(.text:estimate_is_denied) *(.text:fast_open_bridge) *(.text:fast_watch_jump)
                      *(.text:fault_set_both) *(.text:measure_noise) *(.text:reason_of) *(.text:still_watch_holds)
                      /* firmware/fast/fast_window.c */
                      *(.text:fast_begin_sums) *(.text:fast_close) *(.text:fault_set_none) *(.text:pair_ab) *(.text:pair_dq)
                      *(.text:snapshot)
                      /* firmware/fast/inverter/svpwm.c */
                      *(.text:leg) *(.text:shortened) *(.text:svpwm_beyond)
                      /* firmware/fast/reference/catch.c */
                      *(.text:turned_on)
                      /* firmware/fast/reference/reference.c */
                      *(.text:caught) *(.text:forced_step) *(.text:lock_to) *(.text:reference_follow_catch)
                      *(.text:reference_force) *(.text:reference_obey) *(.text:reference_rest) *(.text:reference_run_locked)
                      *(.text:reference_take)
                      /* firmware/guard/guard.c */
                      *(.text:fault_set_common) *(.text:fault_set_has) *(.text:rows_if)
                      /* firmware/math/pi.c */
                      *(.text:pi_reset)
                      /* firmware/math/tanh.c */
                      *(.text:tanh_ratio_at) *(.text:tanh_ratio_far)
                      /* firmware/talk/daq_copy.c */
                      *(.text:copy) *(.text:daq_copy)
                      /* hal/f28335/adc.c */
                      *(.text:adc_rearm)
                      /* hal/f28335/board.c */
                      *(.text:hal_end_of_sample) *(.text:hal_outputs) *(.text:hal_read) *(.text:hal_time) *(.text:is_enabled)
                      *(.text:set_pin) *(.text:zero_after_late)
                      /* hal/f28335/clock.c */
                      *(.text:clock_carrier_runs) *(.text:set_flash_waits)
                      /* hal/f28335/interrupts.c */
                      *(.text:group_bit) *(.text:hal_end_of_trip) *(.text:hal_request_medium) *(.text:interrupts_acknowledge)
                      *(.text:unexpected)
                      /* hal/f28335/pwm.c */
                      *(.text:any_trip_flag) *(.text:at_most_full) *(.text:hal_gates_off) *(.text:hal_gates_on)
                      *(.text:hal_write_compare) *(.text:leg_is_safe) *(.text:pwm_any_tripped) *(.text:pwm_elapsed)
                      *(.text:pwm_fault_line)
                      /* hal/f28335/qep.c */
                      *(.text:qep_keep_step) *(.text:qep_take_error)
                      /* hal/f28335/wait.c */
                      *(.text:bus_wait)
                      /* end: tools/check-linker */
                    }
                    LOAD = FLASH_H_D, RUN = L0_L3,
                    LOAD_START(ramfunc_load_start), LOAD_SIZE(ramfunc_load_size), RUN_START(ramfunc_run_start)

    .stack        : > M0_M1, RUN_START(stack_start), RUN_SIZE(stack_size)
    .bss          : > L4_L7
    .data         : > L4_L7
    .sysmem       : > L4_L7

    FPUmathTables : > FPU_TABLES, TYPE = NOLOAD
    .reset        : > RESET, TYPE = DSECT
}
