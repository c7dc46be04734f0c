"""From each hazard to its limit, its code, its tests and the faults that test it: docs/evidence.md.

`python -m tests.evidence > docs/evidence.md` writes the page. A test of this folder says what is missing or not there.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from robustness.faults import GROUPS


@dataclass(frozen=True, slots=True)
class Hazard:
    """What could hurt an operator or a patient, or mislead them.

    Attributes:
        name: what could happen.
        limits: constants of `common.limits`; empty where no number limits it.
        code: modules that keep it from happening.
        tests: `file::test`, or files.
        faults: keys of the fault table.
    """

    name: str
    limits: tuple[str, ...]
    code: tuple[str, ...]
    tests: tuple[str, ...]
    faults: tuple[str, ...]


_GATE, _PATIENT_GATE = (
    "tests/unit/operator_site/safety/test_operator_gate.py",
    "tests/unit/remote_site/safety/test_patient_gate.py",
)
_SAFE_STATES = "tests/unit/common/timing/test_safe_states.py"

HAZARDS = (
    Hazard(
        "an operator's plate is too hot or too cold",
        ("WIDE", "COMFORT", "PLATE_FAULT_C", "PLATE_PEAK_C", "PLATE_HEATING_K_S", "PLATE_COOLING_K_S"),
        (
            "operator_site.safety.operator_gate",
            "operator_site.safety.plate_following",
            "operator_site.safety.plate_load",
            "common.safety.repeated_fault",
        ),
        (
            f"{_GATE}::test_plate_set_point_range_and_rate",
            f"{_GATE}::test_hot_plate_is_a_fault_that_latches_for_all",
            f"{_GATE}::test_single_fault_is_found_and_stays_below_the_peak",
            f"{_GATE}::test_a_plate_that_does_not_pass_its_test_gets_no_more_than_a_pulse_in_half_a_minute",
            "tests/unit/operator_site/safety/test_plate_following.py",
            "tests/unit/operator_site/safety/test_plate_load.py",
            "tests/unit/common/safety/test_repeated_fault.py",
            "tests/virtual/test_fingertip_faults.py",
            "tests/virtual/test_sound_plates.py",
        ),
        (
            "sim-operator-thermistor-middle-frozen",
            "sim-operator-thermistor-middle-open",
            "sim-operator-thermistor-middle-short",
            "sim-operator-reverse-middle",
            "sim-operator-water-middle",
        ),
    ),
    Hazard(
        "skin is warm for too long",
        ("DOSE_ABOVE_C", "DOSE_LIMIT_K_S", "DOSE_WINDOW_S"),
        ("common.safety.thermal_dose", "operator_site.safety.operator_gate", "remote_site.safety.heater_limits"),
        (
            "tests/unit/common/safety/test_thermal_dose.py",
            f"{_GATE}::test_dose_is_spent_before_it_is_exceeded_and_comes_back",
            f"{_GATE}::test_dose_counts_a_gap_at_the_hotter_of_its_two_ends",
            f"{_PATIENT_GATE}::test_dose_is_spent_before_it_is_exceeded_and_comes_back",
            f"{_PATIENT_GATE}::test_dose_counts_a_gap_at_the_hotter_of_its_two_ends",
        ),
        (),
    ),
    Hazard(
        "a finger is pushed too hard or at once",
        ("FINGER_FORCE_N", "FORCE_RAMP_UP_N_S", "FORCE_RAMP_DOWN_N_S"),
        ("operator_site.safety.operator_gate", "operator_site.safety.force_limits"),
        (
            f"{_GATE}::test_force_range",
            f"{_GATE}::test_force_rises_slowly_after_engaging_then_is_free",
            f"{_GATE}::test_force_falls_to_zero_in_time",
            "tests/virtual/test_steady.py::test_force_ramps_up_from_zero_on_engaging",
        ),
        ("sim-operator-encoder-middle-glitch", "sim-operator-encoder-middle-stuck"),
    ),
    Hazard(
        "force feedback swings, or gives out energy that nobody put in",
        (
            "PRODUCED_J",
            "ACCOUNT_J",
            "FORGIVEN_W",
            "SWING_N",
            "SWING_CYCLES",
            "SWING_S",
            "SWING_SLOW_HZ",
            "SWING_SLOW_CYCLES",
        ),
        (
            "operator_site.safety.passivity_controller",
            "common.safety.oscillation_detector",
            "operator_site.safety.force_limits",
            "operator_site.safety.sampled_wall",
        ),
        (
            f"{_GATE}::test_energy_out_never_exceeds_energy_in_for_any_request",
            f"{_GATE}::test_a_force_that_swings_is_a_fault_until_it_is_cleared",
            "tests/unit/operator_site/safety/test_passivity_controller.py",
            "tests/unit/common/safety/test_oscillation_detector.py",
        ),
        (),
    ),
    Hazard(
        "vibration is stronger than the motor may be driven",
        ("MOTOR_FLOOR_RPM", "MOTOR_MAX_RPM"),
        ("operator_site.safety.operator_gate",),
        (f"{_GATE}::test_motor_range",),
        ("sim-operator-motor-middle-2999",),
    ),
    Hazard(
        "a sensor's heated plate burns the patient",
        ("SENSOR_PLATE_C",),
        (
            "remote_site.safety.patient_gate",
            "remote_site.safety.heater_limits",
            "remote_site.safety.slow_heating",
            "remote_site.safety.holding_loss",
            "common.safety.repeated_fault",
        ),
        (
            f"{_PATIENT_GATE}::test_hot_sensor_plate_is_a_fault",
            f"{_PATIENT_GATE}::test_heater_is_off_on_contact",
            f"{_PATIENT_GATE}::test_heater_looks_ahead_of_its_sensor",
            f"{_PATIENT_GATE}::test_heater_needs_engagement_motion_and_a_believable_reading",
            "tests/unit/remote_site/safety/test_heater_limits.py",
            "tests/unit/remote_site/safety/test_slow_heating.py",
            "tests/unit/remote_site/safety/test_holding_loss.py",
            "tests/unit/common/safety/test_repeated_fault.py",
            "tests/virtual/test_repeated_heater_faults.py",
        ),
        (
            "sim-remote-thermistor-index-open",
            "sim-remote-thermistor-index-short",
            "sim-remote-thermistor-index-frozen",
            "sim-remote-stuck-index-1000",
        ),
    ),
    Hazard(
        "a remote finger presses the patient too hard",
        ("CONTACT_FORCE_N",),
        (
            "remote_site.safety.patient_gate",
            "remote_site.safety.setpoints",
            "remote_site.devices.force_sensor_fault",
        ),
        (
            f"{_PATIENT_GATE}::test_contact_force_stays_below_the_limit_on_an_object",
            f"{_PATIENT_GATE}::test_force_decides_how_fast_a_finger_goes_deeper",
            f"{_PATIENT_GATE}::test_stopped_finger_that_presses_too_hard_leaves_at_once",
            "tests/unit/remote_site/devices/test_force_sensor_fault.py",
        ),
        ("sim-remote-force-middle-frozen", "sim-remote-force-middle-biased", "sim-remote-encoder-middle-glitch"),
    ),
    Hazard(
        "a remote finger presses harder than this patient bears",
        ("PAIN_SHARE", "PAIN_LEAST_N"),
        (
            "remote_site.safety.pain_limit",
            "remote_site.safety.patient_gate",
            "remote_site.devices.patient_switch",
            "common.tenderness.reaction",
        ),
        (
            "tests/unit/remote_site/safety/test_pain_limit.py",
            "tests/unit/remote_site/safety/test_pain_at_the_gate.py",
            "tests/unit/common/tenderness/test_reaction.py",
            "tests/virtual/test_patient_pain.py",
        ),
        (
            "sim-remote-slider-1001",
            "sim-remote-slider-0",
            "sim-remote-slider-gone",
            "sim-remote-slider-1000",
        ),
    ),
    Hazard(
        "the patient wants it to stop, and nothing stops",
        ("PATIENT_STOP_S", "LIFT_OFF_S", "RETREAT_M_S", "SWITCH_SILENCE_S", "SWITCH_LOST_S", "SWITCH_HOLD_S"),
        (
            "remote_site.safety.patient_stop",
            "remote_site.safety.patient_gate",
            "remote_site.devices.patient_switch",
            "common.link.session_state",
        ),
        (
            "tests/unit/remote_site/safety/test_patient_stop.py",
            "tests/unit/remote_site/devices/test_patient_switch.py",
            "tests/unit/common/link/test_session_state.py"
            "::test_the_patients_stop_takes_the_place_of_another_fault_and_is_cleared_here_only",
            "tests/virtual/test_patient_stop.py",
        ),
        (
            "sim-remote-press",
            "sim-remote-press-partition-60",
            "sim-remote-unplug-patient-switch",
            "sim-remote-silence-patient-switch",
            "sim-remote-repeat",
            "sim-remote-babble-patient-switch",
        ),
    ),
    Hazard(
        "a remote finger shakes, or works on the patient without end",
        ("LEFT_J", "LEFT_W"),
        ("remote_site.safety.residual_work", "common.safety.oscillation_detector"),
        (
            f"{_PATIENT_GATE}::test_work_left_in_the_object_slows_the_finger_and_three_such_cycles_are_a_fault",
            f"{_PATIENT_GATE}::test_a_force_that_swings_faster_than_a_hand_is_a_fault_in_half_a_second",
            "tests/unit/remote_site/safety/test_following_error.py"
            "::test_set_points_that_shake_in_contact_as_no_hand_does_are_a_fault_and_the_fingers_leave",
        ),
        (),
    ),
    Hazard(
        "clutch or motion scale makes the remote hand, or the force at a finger, jump",
        (
            "MOTION_SCALES",
            "COUPLING_STEP_M",
            "COUPLING_STEP_N",
            "COUPLING_RAMP_N_S",
            "REMOTE_PLANE_M",
            "REMOTE_LOW_M",
        ),
        (
            "operator_site.coupling.coupling",
            "operator_site.coupling.motion_coupling",
            "operator_site.force.coupled_contact",
            "remote_site.safety.setpoints",
        ),
        (
            "tests/unit/operator_site/coupling/test_coupling.py::test_the_command_never_steps",
            "tests/unit/operator_site/coupling/test_coupled_force.py::test_no_change_makes_a_step_in_force_or_energy",
            "tests/virtual/test_clutch.py",
        ),
        (),
    ),
    Hazard(
        "the remote hand jumps to where the operator's hand is",
        ("APPROACH_PLANE_M_S", "APPROACH_DOWN_M_S"),
        (
            "remote_site.safety.setpoints",
            "remote_site.safety.sliding_extrema",
        ),
        (
            f"{_PATIENT_GATE}::test_set_points_begin_at_the_hand_after_each_release",
            f"{_PATIENT_GATE}::test_a_hand_that_moved_meanwhile_is_approached_without_a_jump",
            f"{_PATIENT_GATE}::test_contact_in_the_approach_is_soft_and_stays_below_the_limit",
            "tests/unit/remote_site/safety/test_sliding_extrema.py",
        ),
        (),
    ),
    Hazard(
        "the telemanipulator does not go where it is sent",
        (),
        ("remote_site.safety.following_error",),
        (
            f"{_PATIENT_GATE}::test_a_hand_that_does_not_follow_is_a_fault",
            f"{_PATIENT_GATE}::test_a_hand_that_moves_after_its_release_is_a_fault_once_it_had_time_to_stop",
            "tests/unit/remote_site/safety/test_following_error.py",
            "tests/unit/remote_site/safety/test_following_error_bounds.py",
        ),
        (
            "sim-remote-disobey",
            "sim-remote-disobey-index",
            "sim-remote-disobey-drift",
            "sim-remote-encoder-index-stuck",
        ),
    ),
    Hazard(
        "outputs stay live although nothing new arrives",
        ("GAP_S", "FORCE_SAFE_S", "MOTOR_SAFE_S", "MOTOR_STILL_S", "THERMAL_SAFE_S"),
        ("operator_site.safety.operator_gate", "remote_site.safety.patient_gate"),
        (
            f"{_SAFE_STATES}::test_the_operators_gate_meets_the_times_of_the_table",
            f"{_SAFE_STATES}::test_the_patients_gate_meets_the_times_of_the_table",
            "tests/virtual/test_partition.py",
            "tests/virtual/test_random_walk.py",
        ),
        (
            "network-partition-1",
            "network-partition-10",
            "network-half-open-5",
            "network-partition-2-to-remote",
            "network-partition-2-to-operator",
            "network-cut",
            "remote-kill",
            "remote-stop-1-s",
            "remote-stop-3-s",
            "remote-slow",
            "operator-kill",
            "operator-stop-1-s",
            "operator-stop-3-s",
            "operator-slow",
            "machine-burn",
        ),
    ),
    Hazard(
        "what is acted on is old, or of another session",
        ("AGE_DEFAULT_S", "AGE_MAX_S"),
        ("common.link.packet_filter", "common.link.clock_offset", "common.timing.standstill"),
        (
            "tests/unit/common/link/test_packet_filter.py",
            "tests/unit/common/link/test_clock_offset.py",
            "tests/unit/common/timing/test_standstill.py",
            "tests/virtual/test_stale_packets.py",
            "tests/virtual/test_delay.py",
            "tests/virtual/test_clock_steps.py",
        ),
        ("network-delay-20-5", "network-delay-100-20", "network-stall-3", "network-delay-400-20"),
    ),
    Hazard(
        "an old picture passes for the present one",
        ("FROZEN_S",),
        ("operator_site.console.camera.picture_reader", "operator_site.console.alarms.alarm_rules"),
        (
            "tests/unit/operator_site/console/camera/test_picture_reader.py",
            "tests/unit/operator_site/console/test_live_camera.py",
        ),
        (),
    ),
    Hazard(
        "an old sound of the voice passes for the present one",
        ("VOICE_AGE_S",),
        ("common.link.voice_end", "remote_site.voice.jitter_buffer"),
        (
            "tests/unit/common/link/test_voice_end.py",
            "tests/unit/remote_site/voice/test_jitter_buffer.py",
        ),
        (),
    ),
    Hazard(
        "a device whose line is cut keeps its output",
        ("MODULE_TIMEOUT_S",),
        ("teletaction.conformance.checklist",),
        (
            f"{_SAFE_STATES}::test_a_module_without_commands_switches_off_within_its_time",
            f"{_SAFE_STATES}::test_a_heater_without_commands_switches_off_within_its_time",
            f"{_SAFE_STATES}::test_an_exoskeleton_without_commands_releases_within_its_time",
            "tests/unit/teletaction/conformance/test_emulators_conform.py",
            "tests/virtual/test_unplugged.py",
        ),
        (
            "sim-remote-unplug-middle-texture",
            "sim-remote-unplug-middle-thermal",
            "sim-operator-unplug-middle-tacttip",
            "sim-remote-unplug-can",
            "sim-operator-unplug-can",
            "sim-remote-silence-can",
            "sim-operator-silence-can",
            "sim-remote-silence-middle-texture",
            "sim-operator-silence-middle-tacttip",
            "sim-remote-kill",
            "sim-remote-stop-1-s",
            "sim-remote-stop-3-s",
            "sim-remote-slow",
            "sim-operator-kill",
            "sim-operator-stop-1-s",
            "sim-operator-stop-3-s",
            "sim-operator-slow",
        ),
    ),
    Hazard(
        "a device does what nobody asked of it",
        (),
        ("common.buses.drive_monitor",),
        ("tests/unit/common/buses/test_drive_monitor.py", "tests/virtual/test_unasked_outputs.py"),
        (
            "sim-operator-stuck-middle-1000",
            "sim-operator-push-index-2",
            "sim-operator-intrude",
            "sim-remote-intrude",
        ),
    ),
    Hazard(
        "damaged frames are believed",
        (),
        ("common.buses.can_frames", "common.buses.serial_messages", "common.buses.encoder_glitches"),
        (
            "tests/unit/common/buses/test_can_frames.py",
            "tests/unit/common/buses/test_serial_framing.py",
            "tests/unit/common/buses/test_frame_error_rate.py",
            "tests/unit/common/buses/test_encoder_glitches.py",
        ),
        (
            "sim-remote-bus-off",
            "sim-operator-bus-off",
            "sim-remote-damage-can-counter-0.5",
            "sim-remote-damage-can-crc-1",
            "sim-operator-damage-can-counter-0.5",
            "sim-operator-damage-can-crc-1",
            "sim-operator-damage-can-crc-0.01",
            "sim-remote-babble-middle-texture",
            "sim-operator-babble-middle-tacttip",
        ),
    ),
    Hazard(
        "texture is felt that is not there",
        (),
        ("remote_site.texture.sensor_fault",),
        ("tests/unit/remote_site/texture/test_sensor_fault.py", "tests/unit/remote_site/texture/test_piezo_faults.py"),
        ("sim-remote-piezo-middle-cut", "sim-remote-piezo-middle-saturated"),
    ),
    Hazard(
        "a fault ends by itself, or a stop does not hold",
        (),
        ("common.link.session_state", "operator_site.session.emergency_stop"),
        ("tests/virtual/test_emergency_stop.py", "tests/virtual/test_latched_faults.py"),
        (),
    ),
    Hazard(
        "somebody acts who may not",
        (),
        ("common.link.keys", "common.link.authenticator"),
        (
            "tests/unit/common/link/test_keys.py",
            "tests/unit/common/link/test_authenticator.py",
            "tests/robustness/adversary/test_trusted_keys.py",
        ),
        (),
    ),
    Hazard(
        "a recording that fails takes the session with it",
        (),
        ("common.recording.recorder",),
        ("tests/unit/common/recording/test_recorder.py", "tests/virtual/test_contained_step.py"),
        ("disk-full",),
    ),
)

HEAD = """# Evidence

Each row has a hazard, its limits, the code that enforces them, and the tests of that code. The last column has the rows
of the [fault matrix](faults.md) that test a whole session. Each limit, each module of a gate and each fault must be in
a row, and each name must exist; a test checks this. `python -m tests.evidence > docs/evidence.md` writes this page.

| hazard | limits (`common.limits`) | code | tests | faults |
|---|---|---|---|---|
"""


def page(hazards: Iterable[Hazard] = HAZARDS) -> str:
    """The page."""
    names = {fault.key: fault.name for faults in GROUPS.values() for fault in faults}

    def cell(words: Iterable[str]) -> str:
        return "<br>".join(words) or "-"

    rows = (
        (
            hazard.name,
            cell(f"`{name}`" for name in hazard.limits),
            cell(f"`{name}`" for name in hazard.code),
            cell(f"`{test.removeprefix('tests/')}`" for test in hazard.tests),
            cell(names[key] for key in hazard.faults),
        )
        for hazard in hazards
    )
    return HEAD + "".join(f"| {' | '.join(row)} |\n" for row in rows)


if __name__ == "__main__":
    print(page(), end="")
