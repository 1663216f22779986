// SPDX-License-Identifier: MIT
/// The MAVLink messages that we know: extend the table, nothing else.
///
/// Fields stand in the order in which they lie in the payload (largest type first, extensions
/// last and marked '+'), so offsets follow from the types. Types are u8 to u64, i8 to i64, f32,
/// f64 and char, with [n] for an array; the unit follows in brackets. The test computes every
/// CRC_EXTRA again from the names and types, so a misspelt line does not pass.
#include "watersky/wire/detail/mavlink_table.hpp"

namespace watersky::mavlink::detail {

namespace {

// clang-format off
constexpr TableRow kRows[] = {
    // id, name, CRC_EXTRA, payload bytes without extensions, with them, fields
    {0, "HEARTBEAT", 50, 9, 9,
     "custom_mode u32; type u8; autopilot u8; base_mode u8; system_status u8; mavlink_version u8"},
    {1, "SYS_STATUS", 124, 31, 43,
     "onboard_control_sensors_present u32; onboard_control_sensors_enabled u32; "
     "onboard_control_sensors_health u32; load u16 [d%]; voltage_battery u16 [mV]; "
     "current_battery i16 [cA]; drop_rate_comm u16 [c%]; errors_comm u16; errors_count1 u16; "
     "errors_count2 u16; errors_count3 u16; errors_count4 u16; battery_remaining i8 [%]; "
     "+onboard_control_sensors_present_extended u32; +onboard_control_sensors_enabled_extended "
     "u32; +onboard_control_sensors_health_extended u32"},
    {2, "SYSTEM_TIME", 137, 12, 12,
     "time_unix_usec u64 [us]; time_boot_ms u32 [ms]"},
    {4, "PING", 237, 14, 14,
     "time_usec u64 [us]; seq u32; target_system u8; target_component u8"},
    {5, "CHANGE_OPERATOR_CONTROL", 217, 28, 28,
     "target_system u8; control_request u8; version u8 [rad]; passkey char[25]"},
    {6, "CHANGE_OPERATOR_CONTROL_ACK", 104, 3, 3,
     "gcs_system_id u8; control_request u8; ack u8"},
    {7, "AUTH_KEY", 119, 32, 32,
     "key char[32]"},
    {11, "SET_MODE", 89, 6, 6,
     "custom_mode u32; target_system u8; base_mode u8"},
    {20, "PARAM_REQUEST_READ", 214, 20, 20,
     "param_index i16; target_system u8; target_component u8; param_id char[16]"},
    {21, "PARAM_REQUEST_LIST", 159, 2, 2,
     "target_system u8; target_component u8"},
    {22, "PARAM_VALUE", 220, 25, 25,
     "param_value f32; param_count u16; param_index u16; param_id char[16]; param_type u8"},
    {23, "PARAM_SET", 168, 23, 23,
     "param_value f32; target_system u8; target_component u8; param_id char[16]; param_type u8"},
    {24, "GPS_RAW_INT", 24, 30, 52,
     "time_usec u64 [us]; lat i32 [degE7]; lon i32 [degE7]; alt i32 [mm]; eph u16; epv u16; vel "
     "u16 [cm/s]; cog u16 [cdeg]; fix_type u8; satellites_visible u8; +alt_ellipsoid i32 [mm]; "
     "+h_acc u32 [mm]; +v_acc u32 [mm]; +vel_acc u32 [mm/s]; +hdg_acc u32 [degE5]; +yaw u16 "
     "[cdeg]"},
    {26, "SCALED_IMU", 170, 22, 24,
     "time_boot_ms u32 [ms]; xacc i16 [mG]; yacc i16 [mG]; zacc i16 [mG]; xgyro i16 [mrad/s]; "
     "ygyro i16 [mrad/s]; zgyro i16 [mrad/s]; xmag i16 [mgauss]; ymag i16 [mgauss]; zmag i16 "
     "[mgauss]; +temperature i16 [cdegC]"},
    {27, "RAW_IMU", 144, 26, 29,
     "time_usec u64 [us]; xacc i16 [mG]; yacc i16 [mG]; zacc i16 [mG]; xgyro i16 [mrad/s]; ygyro "
     "i16 [mrad/s]; zgyro i16 [mrad/s]; xmag i16 [mgauss]; ymag i16 [mgauss]; zmag i16 [mgauss]; "
     "+id u8; +temperature i16 [cdegC]"},
    {29, "SCALED_PRESSURE", 115, 14, 16,
     "time_boot_ms u32 [ms]; press_abs f32 [hPa]; press_diff f32 [hPa]; temperature i16 [cdegC]; "
     "+temperature_press_diff i16 [cdegC]"},
    {30, "ATTITUDE", 39, 28, 28,
     "time_boot_ms u32 [ms]; roll f32 [rad]; pitch f32 [rad]; yaw f32 [rad]; rollspeed f32 "
     "[rad/s]; pitchspeed f32 [rad/s]; yawspeed f32 [rad/s]"},
    {31, "ATTITUDE_QUATERNION", 246, 32, 48,
     "time_boot_ms u32 [ms]; q1 f32; q2 f32; q3 f32; q4 f32; rollspeed f32 [rad/s]; pitchspeed "
     "f32 [rad/s]; yawspeed f32 [rad/s]; +repr_offset_q f32[4]"},
    {32, "LOCAL_POSITION_NED", 185, 28, 28,
     "time_boot_ms u32 [ms]; x f32 [m]; y f32 [m]; z f32 [m]; vx f32 [m/s]; vy f32 [m/s]; vz f32 "
     "[m/s]"},
    {33, "GLOBAL_POSITION_INT", 104, 28, 28,
     "time_boot_ms u32 [ms]; lat i32 [degE7]; lon i32 [degE7]; alt i32 [mm]; relative_alt i32 "
     "[mm]; vx i16 [cm/s]; vy i16 [cm/s]; vz i16 [cm/s]; hdg u16 [cdeg]"},
    {35, "RC_CHANNELS_RAW", 244, 22, 22,
     "time_boot_ms u32 [ms]; chan1_raw u16 [us]; chan2_raw u16 [us]; chan3_raw u16 [us]; "
     "chan4_raw u16 [us]; chan5_raw u16 [us]; chan6_raw u16 [us]; chan7_raw u16 [us]; chan8_raw "
     "u16 [us]; port u8; rssi u8"},
    {36, "SERVO_OUTPUT_RAW", 222, 21, 37,
     "time_usec u32 [us]; servo1_raw u16 [us]; servo2_raw u16 [us]; servo3_raw u16 [us]; "
     "servo4_raw u16 [us]; servo5_raw u16 [us]; servo6_raw u16 [us]; servo7_raw u16 [us]; "
     "servo8_raw u16 [us]; port u8; +servo9_raw u16 [us]; +servo10_raw u16 [us]; +servo11_raw "
     "u16 [us]; +servo12_raw u16 [us]; +servo13_raw u16 [us]; +servo14_raw u16 [us]; "
     "+servo15_raw u16 [us]; +servo16_raw u16 [us]"},
    {37, "MISSION_REQUEST_PARTIAL_LIST", 212, 6, 7,
     "start_index i16; end_index i16; target_system u8; target_component u8; +mission_type u8"},
    {38, "MISSION_WRITE_PARTIAL_LIST", 9, 6, 7,
     "start_index i16; end_index i16; target_system u8; target_component u8; +mission_type u8"},
    {39, "MISSION_ITEM", 254, 37, 38,
     "param1 f32; param2 f32; param3 f32; param4 f32; x f32; y f32; z f32; seq u16; command u16; "
     "target_system u8; target_component u8; frame u8; current u8; autocontinue u8; "
     "+mission_type u8"},
    {40, "MISSION_REQUEST", 230, 4, 5,
     "seq u16; target_system u8; target_component u8; +mission_type u8"},
    {41, "MISSION_SET_CURRENT", 28, 4, 4,
     "seq u16; target_system u8; target_component u8"},
    {42, "MISSION_CURRENT", 28, 2, 6,
     "seq u16; +total u16; +mission_state u8; +mission_mode u8"},
    {43, "MISSION_REQUEST_LIST", 132, 2, 3,
     "target_system u8; target_component u8; +mission_type u8"},
    {44, "MISSION_COUNT", 221, 4, 5,
     "count u16; target_system u8; target_component u8; +mission_type u8"},
    {45, "MISSION_CLEAR_ALL", 232, 2, 3,
     "target_system u8; target_component u8; +mission_type u8"},
    {46, "MISSION_ITEM_REACHED", 11, 2, 2,
     "seq u16"},
    {47, "MISSION_ACK", 153, 3, 4,
     "target_system u8; target_component u8; type u8; +mission_type u8"},
    {48, "SET_GPS_GLOBAL_ORIGIN", 41, 13, 21,
     "latitude i32 [degE7]; longitude i32 [degE7]; altitude i32 [mm]; target_system u8; "
     "+time_usec u64 [us]"},
    {49, "GPS_GLOBAL_ORIGIN", 39, 12, 20,
     "latitude i32 [degE7]; longitude i32 [degE7]; altitude i32 [mm]; +time_usec u64 [us]"},
    {51, "MISSION_REQUEST_INT", 196, 4, 5,
     "seq u16; target_system u8; target_component u8; +mission_type u8"},
    {61, "ATTITUDE_QUATERNION_COV", 167, 72, 72,
     "time_usec u64 [us]; q f32[4]; rollspeed f32 [rad/s]; pitchspeed f32 [rad/s]; yawspeed f32 "
     "[rad/s]; covariance f32[9]"},
    {62, "NAV_CONTROLLER_OUTPUT", 183, 26, 26,
     "nav_roll f32 [deg]; nav_pitch f32 [deg]; alt_error f32 [m]; aspd_error f32 [m/s]; "
     "xtrack_error f32 [m]; nav_bearing i16 [deg]; target_bearing i16 [deg]; wp_dist u16 [m]"},
    {63, "GLOBAL_POSITION_INT_COV", 119, 181, 181,
     "time_usec u64 [us]; lat i32 [degE7]; lon i32 [degE7]; alt i32 [mm]; relative_alt i32 [mm]; "
     "vx f32 [m/s]; vy f32 [m/s]; vz f32 [m/s]; covariance f32[36]; estimator_type u8"},
    {64, "LOCAL_POSITION_NED_COV", 191, 225, 225,
     "time_usec u64 [us]; x f32 [m]; y f32 [m]; z f32 [m]; vx f32 [m/s]; vy f32 [m/s]; vz f32 "
     "[m/s]; ax f32 [m/s/s]; ay f32 [m/s/s]; az f32 [m/s/s]; covariance f32[45]; estimator_type "
     "u8"},
    {65, "RC_CHANNELS", 118, 42, 42,
     "time_boot_ms u32 [ms]; chan1_raw u16 [us]; chan2_raw u16 [us]; chan3_raw u16 [us]; "
     "chan4_raw u16 [us]; chan5_raw u16 [us]; chan6_raw u16 [us]; chan7_raw u16 [us]; chan8_raw "
     "u16 [us]; chan9_raw u16 [us]; chan10_raw u16 [us]; chan11_raw u16 [us]; chan12_raw u16 "
     "[us]; chan13_raw u16 [us]; chan14_raw u16 [us]; chan15_raw u16 [us]; chan16_raw u16 [us]; "
     "chan17_raw u16 [us]; chan18_raw u16 [us]; chancount u8; rssi u8"},
    {66, "REQUEST_DATA_STREAM", 148, 6, 6,
     "req_message_rate u16 [Hz]; target_system u8; target_component u8; req_stream_id u8; "
     "start_stop u8"},
    {67, "DATA_STREAM", 21, 4, 4,
     "message_rate u16 [Hz]; stream_id u8; on_off u8"},
    {69, "MANUAL_CONTROL", 243, 11, 30,
     "x i16; y i16; z i16; r i16; buttons u16; target u8; +buttons2 u16; +enabled_extensions u8; "
     "+s i16; +t i16; +aux1 i16; +aux2 i16; +aux3 i16; +aux4 i16; +aux5 i16; +aux6 i16"},
    {70, "RC_CHANNELS_OVERRIDE", 124, 18, 38,
     "chan1_raw u16 [us]; chan2_raw u16 [us]; chan3_raw u16 [us]; chan4_raw u16 [us]; chan5_raw "
     "u16 [us]; chan6_raw u16 [us]; chan7_raw u16 [us]; chan8_raw u16 [us]; target_system u8; "
     "target_component u8; +chan9_raw u16 [us]; +chan10_raw u16 [us]; +chan11_raw u16 [us]; "
     "+chan12_raw u16 [us]; +chan13_raw u16 [us]; +chan14_raw u16 [us]; +chan15_raw u16 [us]; "
     "+chan16_raw u16 [us]; +chan17_raw u16 [us]; +chan18_raw u16 [us]"},
    {73, "MISSION_ITEM_INT", 38, 37, 38,
     "param1 f32; param2 f32; param3 f32; param4 f32; x i32; y i32; z f32; seq u16; command u16; "
     "target_system u8; target_component u8; frame u8; current u8; autocontinue u8; "
     "+mission_type u8"},
    {74, "VFR_HUD", 20, 20, 20,
     "airspeed f32 [m/s]; groundspeed f32 [m/s]; alt f32 [m]; climb f32 [m/s]; heading i16 "
     "[deg]; throttle u16 [%]"},
    {75, "COMMAND_INT", 158, 35, 35,
     "param1 f32; param2 f32; param3 f32; param4 f32; x i32; y i32; z f32; command u16; "
     "target_system u8; target_component u8; frame u8; current u8; autocontinue u8"},
    {76, "COMMAND_LONG", 152, 33, 33,
     "param1 f32; param2 f32; param3 f32; param4 f32; param5 f32; param6 f32; param7 f32; "
     "command u16; target_system u8; target_component u8; confirmation u8"},
    {77, "COMMAND_ACK", 143, 3, 10,
     "command u16; result u8; +progress u8; +result_param2 i32; +target_system u8; "
     "+target_component u8"},
    {82, "SET_ATTITUDE_TARGET", 49, 39, 51,
     "time_boot_ms u32 [ms]; q f32[4]; body_roll_rate f32 [rad/s]; body_pitch_rate f32 [rad/s]; "
     "body_yaw_rate f32 [rad/s]; thrust f32; target_system u8; target_component u8; type_mask "
     "u8; +thrust_body f32[3]"},
    {83, "ATTITUDE_TARGET", 22, 37, 37,
     "time_boot_ms u32 [ms]; q f32[4]; body_roll_rate f32 [rad/s]; body_pitch_rate f32 [rad/s]; "
     "body_yaw_rate f32 [rad/s]; thrust f32; type_mask u8"},
    {84, "SET_POSITION_TARGET_LOCAL_NED", 143, 53, 53,
     "time_boot_ms u32 [ms]; x f32 [m]; y f32 [m]; z f32 [m]; vx f32 [m/s]; vy f32 [m/s]; vz f32 "
     "[m/s]; afx f32 [m/s/s]; afy f32 [m/s/s]; afz f32 [m/s/s]; yaw f32 [rad]; yaw_rate f32 "
     "[rad/s]; type_mask u16; target_system u8; target_component u8; coordinate_frame u8"},
    {85, "POSITION_TARGET_LOCAL_NED", 140, 51, 51,
     "time_boot_ms u32 [ms]; x f32 [m]; y f32 [m]; z f32 [m]; vx f32 [m/s]; vy f32 [m/s]; vz f32 "
     "[m/s]; afx f32 [m/s/s]; afy f32 [m/s/s]; afz f32 [m/s/s]; yaw f32 [rad]; yaw_rate f32 "
     "[rad/s]; type_mask u16; coordinate_frame u8"},
    {86, "SET_POSITION_TARGET_GLOBAL_INT", 5, 53, 53,
     "time_boot_ms u32 [ms]; lat_int i32 [degE7]; lon_int i32 [degE7]; alt f32 [m]; vx f32 "
     "[m/s]; vy f32 [m/s]; vz f32 [m/s]; afx f32 [m/s/s]; afy f32 [m/s/s]; afz f32 [m/s/s]; yaw "
     "f32 [rad]; yaw_rate f32 [rad/s]; type_mask u16; target_system u8; target_component u8; "
     "coordinate_frame u8"},
    {87, "POSITION_TARGET_GLOBAL_INT", 150, 51, 51,
     "time_boot_ms u32 [ms]; lat_int i32 [degE7]; lon_int i32 [degE7]; alt f32 [m]; vx f32 "
     "[m/s]; vy f32 [m/s]; vz f32 [m/s]; afx f32 [m/s/s]; afy f32 [m/s/s]; afz f32 [m/s/s]; yaw "
     "f32 [rad]; yaw_rate f32 [rad/s]; type_mask u16; coordinate_frame u8"},
    {89, "LOCAL_POSITION_NED_SYSTEM_GLOBAL_OFFSET", 231, 28, 28,
     "time_boot_ms u32 [ms]; x f32 [m]; y f32 [m]; z f32 [m]; roll f32 [rad]; pitch f32 [rad]; "
     "yaw f32 [rad]"},
    {90, "HIL_STATE", 183, 56, 56,
     "time_usec u64 [us]; roll f32 [rad]; pitch f32 [rad]; yaw f32 [rad]; rollspeed f32 [rad/s]; "
     "pitchspeed f32 [rad/s]; yawspeed f32 [rad/s]; lat i32 [degE7]; lon i32 [degE7]; alt i32 "
     "[mm]; vx i16 [cm/s]; vy i16 [cm/s]; vz i16 [cm/s]; xacc i16 [mG]; yacc i16 [mG]; zacc i16 "
     "[mG]"},
    {101, "GLOBAL_VISION_POSITION_ESTIMATE", 102, 32, 117,
     "usec u64 [us]; x f32 [m]; y f32 [m]; z f32 [m]; roll f32 [rad]; pitch f32 [rad]; yaw f32 "
     "[rad]; +covariance f32[21]; +reset_counter u8"},
    {102, "VISION_POSITION_ESTIMATE", 158, 32, 117,
     "usec u64 [us]; x f32 [m]; y f32 [m]; z f32 [m]; roll f32 [rad]; pitch f32 [rad]; yaw f32 "
     "[rad]; +covariance f32[21]; +reset_counter u8"},
    {103, "VISION_SPEED_ESTIMATE", 208, 20, 57,
     "usec u64 [us]; x f32 [m/s]; y f32 [m/s]; z f32 [m/s]; +covariance f32[9]; +reset_counter "
     "u8"},
    {105, "HIGHRES_IMU", 93, 62, 63,
     "time_usec u64 [us]; xacc f32 [m/s/s]; yacc f32 [m/s/s]; zacc f32 [m/s/s]; xgyro f32 "
     "[rad/s]; ygyro f32 [rad/s]; zgyro f32 [rad/s]; xmag f32 [gauss]; ymag f32 [gauss]; zmag "
     "f32 [gauss]; abs_pressure f32 [hPa]; diff_pressure f32 [hPa]; pressure_alt f32; "
     "temperature f32 [degC]; fields_updated u16; +id u8"},
    {108, "SIM_STATE", 32, 84, 92,
     "q1 f32; q2 f32; q3 f32; q4 f32; roll f32 [rad]; pitch f32 [rad]; yaw f32 [rad]; xacc f32 "
     "[m/s/s]; yacc f32 [m/s/s]; zacc f32 [m/s/s]; xgyro f32 [rad/s]; ygyro f32 [rad/s]; zgyro "
     "f32 [rad/s]; lat f32 [deg]; lon f32 [deg]; alt f32 [m]; std_dev_horz f32; std_dev_vert "
     "f32; vn f32 [m/s]; ve f32 [m/s]; vd f32 [m/s]; +lat_int i32 [degE7]; +lon_int i32 [degE7]"},
    {109, "RADIO_STATUS", 185, 9, 9,
     "rxerrors u16; fixed u16; rssi u8; remrssi u8; txbuf u8 [%]; noise u8; remnoise u8"},
    {110, "FILE_TRANSFER_PROTOCOL", 84, 254, 254,
     "target_network u8; target_system u8; target_component u8; payload u8[251]"},
    {111, "TIMESYNC", 34, 16, 16,
     "tc1 i64 [ns]; ts1 i64 [ns]"},
    {112, "CAMERA_TRIGGER", 174, 12, 12,
     "time_usec u64 [us]; seq u32"},
    {113, "HIL_GPS", 124, 36, 39,
     "time_usec u64 [us]; lat i32 [degE7]; lon i32 [degE7]; alt i32 [mm]; eph u16; epv u16; vel "
     "u16 [cm/s]; vn i16 [cm/s]; ve i16 [cm/s]; vd i16 [cm/s]; cog u16 [cdeg]; fix_type u8; "
     "satellites_visible u8; +id u8; +yaw u16 [cdeg]"},
    {116, "SCALED_IMU2", 76, 22, 24,
     "time_boot_ms u32 [ms]; xacc i16 [mG]; yacc i16 [mG]; zacc i16 [mG]; xgyro i16 [mrad/s]; "
     "ygyro i16 [mrad/s]; zgyro i16 [mrad/s]; xmag i16 [mgauss]; ymag i16 [mgauss]; zmag i16 "
     "[mgauss]; +temperature i16 [cdegC]"},
    {117, "LOG_REQUEST_LIST", 128, 6, 6,
     "start u16; end u16; target_system u8; target_component u8"},
    {118, "LOG_ENTRY", 56, 14, 14,
     "time_utc u32 [s]; size u32 [bytes]; id u16; num_logs u16; last_log_num u16"},
    {119, "LOG_REQUEST_DATA", 116, 12, 12,
     "ofs u32; count u32 [bytes]; id u16; target_system u8; target_component u8"},
    {120, "LOG_DATA", 134, 97, 97,
     "ofs u32; id u16; count u8 [bytes]; data u8[90]"},
    {121, "LOG_ERASE", 237, 2, 2,
     "target_system u8; target_component u8"},
    {122, "LOG_REQUEST_END", 203, 2, 2,
     "target_system u8; target_component u8"},
    {123, "GPS_INJECT_DATA", 250, 113, 113,
     "target_system u8; target_component u8; len u8 [bytes]; data u8[110]"},
    {124, "GPS2_RAW", 87, 35, 57,
     "time_usec u64 [us]; lat i32 [degE7]; lon i32 [degE7]; alt i32 [mm]; dgps_age u32 [ms]; eph "
     "u16; epv u16; vel u16 [cm/s]; cog u16 [cdeg]; fix_type u8; satellites_visible u8; "
     "dgps_numch u8; +yaw u16 [cdeg]; +alt_ellipsoid i32 [mm]; +h_acc u32 [mm]; +v_acc u32 [mm]; "
     "+vel_acc u32 [mm/s]; +hdg_acc u32 [degE5]"},
    {125, "POWER_STATUS", 203, 6, 6,
     "Vcc u16 [mV]; Vservo u16 [mV]; flags u16"},
    {129, "SCALED_IMU3", 46, 22, 24,
     "time_boot_ms u32 [ms]; xacc i16 [mG]; yacc i16 [mG]; zacc i16 [mG]; xgyro i16 [mrad/s]; "
     "ygyro i16 [mrad/s]; zgyro i16 [mrad/s]; xmag i16 [mgauss]; ymag i16 [mgauss]; zmag i16 "
     "[mgauss]; +temperature i16 [cdegC]"},
    {130, "DATA_TRANSMISSION_HANDSHAKE", 29, 13, 13,
     "size u32 [bytes]; width u16; height u16; packets u16; type u8; payload u8 [bytes]; "
     "jpg_quality u8 [%]"},
    {131, "ENCAPSULATED_DATA", 223, 255, 255,
     "seqnr u16; data u8[253]"},
    {132, "DISTANCE_SENSOR", 85, 14, 39,
     "time_boot_ms u32 [ms]; min_distance u16 [cm]; max_distance u16 [cm]; current_distance u16 "
     "[cm]; type u8; id u8; orientation u8; covariance u8 [cm^2]; +horizontal_fov f32 [rad]; "
     "+vertical_fov f32 [rad]; +quaternion f32[4]; +signal_quality u8 [%]"},
    {136, "TERRAIN_REPORT", 1, 22, 22,
     "lat i32 [degE7]; lon i32 [degE7]; terrain_height f32 [m]; current_height f32 [m]; spacing "
     "u16; pending u16; loaded u16"},
    {137, "SCALED_PRESSURE2", 195, 14, 16,
     "time_boot_ms u32 [ms]; press_abs f32 [hPa]; press_diff f32 [hPa]; temperature i16 [cdegC]; "
     "+temperature_press_diff i16 [cdegC]"},
    {138, "ATT_POS_MOCAP", 109, 36, 120,
     "time_usec u64 [us]; q f32[4]; x f32 [m]; y f32 [m]; z f32 [m]; +covariance f32[21]"},
    {141, "ALTITUDE", 47, 32, 32,
     "time_usec u64 [us]; altitude_monotonic f32 [m]; altitude_amsl f32 [m]; altitude_local f32 "
     "[m]; altitude_relative f32 [m]; altitude_terrain f32 [m]; bottom_clearance f32 [m]"},
    {143, "SCALED_PRESSURE3", 131, 14, 16,
     "time_boot_ms u32 [ms]; press_abs f32 [hPa]; press_diff f32 [hPa]; temperature i16 [cdegC]; "
     "+temperature_press_diff i16 [cdegC]"},
    {144, "FOLLOW_TARGET", 127, 93, 93,
     "timestamp u64 [ms]; custom_state u64; lat i32 [degE7]; lon i32 [degE7]; alt f32 [m]; vel "
     "f32[3] [m/s]; acc f32[3] [m/s/s]; attitude_q f32[4]; rates f32[3]; position_cov f32[3]; "
     "est_capabilities u8"},
    {147, "BATTERY_STATUS", 154, 36, 54,
     "current_consumed i32 [mAh]; energy_consumed i32 [hJ]; temperature i16 [cdegC]; voltages "
     "u16[10] [mV]; current_battery i16 [cA]; id u8; battery_function u8; type u8; "
     "battery_remaining i8 [%]; +time_remaining i32 [s]; +charge_state u8; +voltages_ext u16[4] "
     "[mV]; +mode u8; +fault_bitmask u32"},
    {148, "AUTOPILOT_VERSION", 178, 60, 78,
     "capabilities u64; uid u64; flight_sw_version u32; middleware_sw_version u32; os_sw_version "
     "u32; board_version u32; vendor_id u16; product_id u16; flight_custom_version u8[8]; "
     "middleware_custom_version u8[8]; os_custom_version u8[8]; +uid2 u8[18]"},
    {149, "LANDING_TARGET", 200, 30, 60,
     "time_usec u64 [us]; angle_x f32 [rad]; angle_y f32 [rad]; distance f32 [m]; size_x f32 "
     "[rad]; size_y f32 [rad]; target_num u8; frame u8; +x f32 [m]; +y f32 [m]; +z f32 [m]; +q "
     "f32[4]; +type u8; +position_valid u8"},
    {152, "MEMINFO", 208, 4, 8,
     "brkval u16; freemem u16 [bytes]; +freemem32 u32 [bytes]"},
    {155, "DIGICAM_CONTROL", 22, 13, 13,
     "extra_value f32; target_system u8; target_component u8; session u8; zoom_pos u8; zoom_step "
     "i8; focus_lock u8; shot u8; command_id u8; extra_param u8"},
    {156, "MOUNT_CONFIGURE", 19, 6, 6,
     "target_system u8; target_component u8; mount_mode u8; stab_roll u8; stab_pitch u8; "
     "stab_yaw u8"},
    {157, "MOUNT_CONTROL", 21, 15, 15,
     "input_a i32; input_b i32; input_c i32; target_system u8; target_component u8; "
     "save_position u8"},
    {158, "MOUNT_STATUS", 134, 14, 15,
     "pointing_a i32 [cdeg]; pointing_b i32 [cdeg]; pointing_c i32 [cdeg]; target_system u8; "
     "target_component u8; +mount_mode u8"},
    {160, "FENCE_POINT", 78, 12, 12,
     "lat f32 [deg]; lng f32 [deg]; target_system u8; target_component u8; idx u8; count u8"},
    {161, "FENCE_FETCH_POINT", 68, 3, 3,
     "target_system u8; target_component u8; idx u8"},
    {162, "FENCE_STATUS", 189, 8, 9,
     "breach_time u32 [ms]; breach_count u16; breach_status u8; breach_type u8; "
     "+breach_mitigation u8"},
    {163, "AHRS", 127, 28, 28,
     "omegaIx f32 [rad/s]; omegaIy f32 [rad/s]; omegaIz f32 [rad/s]; accel_weight f32; "
     "renorm_val f32; error_rp f32; error_yaw f32"},
    {164, "SIMSTATE", 154, 44, 44,
     "roll f32 [rad]; pitch f32 [rad]; yaw f32 [rad]; xacc f32 [m/s/s]; yacc f32 [m/s/s]; zacc "
     "f32 [m/s/s]; xgyro f32 [rad/s]; ygyro f32 [rad/s]; zgyro f32 [rad/s]; lat i32 [degE7]; lng "
     "i32 [degE7]"},
    {165, "HWSTATUS", 21, 3, 3,
     "Vcc u16 [mV]; I2Cerr u8"},
    {166, "RADIO", 21, 9, 9,
     "rxerrors u16; fixed u16; rssi u8; remrssi u8; txbuf u8 [%]; noise u8; remnoise u8"},
    {168, "WIND", 1, 12, 12,
     "direction f32 [deg]; speed f32 [m/s]; speed_z f32 [m/s]"},
    {173, "RANGEFINDER", 83, 8, 8,
     "distance f32 [m]; voltage f32 [V]"},
    {175, "RALLY_POINT", 138, 19, 19,
     "lat i32 [degE7]; lng i32 [degE7]; alt i16 [m]; break_alt i16 [m]; land_dir u16 [cdeg]; "
     "target_system u8; target_component u8; idx u8; count u8; flags u8"},
    {176, "RALLY_FETCH_POINT", 234, 3, 3,
     "target_system u8; target_component u8; idx u8"},
    {178, "AHRS2", 47, 24, 24,
     "roll f32 [rad]; pitch f32 [rad]; yaw f32 [rad]; altitude f32 [m]; lat i32 [degE7]; lng i32 "
     "[degE7]"},
    {179, "CAMERA_STATUS", 189, 29, 29,
     "time_usec u64 [us]; p1 f32; p2 f32; p3 f32; p4 f32; img_idx u16; target_system u8; cam_idx "
     "u8; event_id u8"},
    {180, "CAMERA_FEEDBACK", 52, 45, 47,
     "time_usec u64 [us]; lat i32 [degE7]; lng i32 [degE7]; alt_msl f32 [m]; alt_rel f32 [m]; "
     "roll f32 [deg]; pitch f32 [deg]; yaw f32 [deg]; foc_len f32 [mm]; img_idx u16; "
     "target_system u8; cam_idx u8; flags u8; +completed_captures u16"},
    {181, "BATTERY2", 174, 4, 4,
     "voltage u16 [mV]; current_battery i16 [cA]"},
    {183, "AUTOPILOT_VERSION_REQUEST", 85, 2, 2,
     "target_system u8; target_component u8"},
    {192, "MAG_CAL_REPORT", 36, 44, 54,
     "fitness f32 [mgauss]; ofs_x f32; ofs_y f32; ofs_z f32; diag_x f32; diag_y f32; diag_z f32; "
     "offdiag_x f32; offdiag_y f32; offdiag_z f32; compass_id u8; cal_mask u8; cal_status u8; "
     "autosaved u8; +orientation_confidence f32; +old_orientation u8; +new_orientation u8; "
     "+scale_factor f32"},
    {193, "EKF_STATUS_REPORT", 71, 22, 26,
     "velocity_variance f32; pos_horiz_variance f32; pos_vert_variance f32; compass_variance "
     "f32; terrain_alt_variance f32; flags u16; +airspeed_variance f32"},
    {226, "RPM", 207, 8, 8,
     "rpm1 f32; rpm2 f32"},
    {230, "ESTIMATOR_STATUS", 163, 42, 42,
     "time_usec u64 [us]; vel_ratio f32; pos_horiz_ratio f32; pos_vert_ratio f32; mag_ratio f32; "
     "hagl_ratio f32; tas_ratio f32; pos_horiz_accuracy f32 [m]; pos_vert_accuracy f32 [m]; "
     "flags u16"},
    {231, "WIND_COV", 105, 40, 40,
     "time_usec u64 [us]; wind_x f32 [m/s]; wind_y f32 [m/s]; wind_z f32 [m/s]; var_horiz f32 "
     "[m/s]; var_vert f32 [m/s]; wind_alt f32 [m]; horiz_accuracy f32 [m/s]; vert_accuracy f32 "
     "[m/s]"},
    {232, "GPS_INPUT", 151, 63, 65,
     "time_usec u64 [us]; time_week_ms u32 [ms]; lat i32 [degE7]; lon i32 [degE7]; alt f32 [m]; "
     "hdop f32; vdop f32; vn f32 [m/s]; ve f32 [m/s]; vd f32 [m/s]; speed_accuracy f32 [m/s]; "
     "horiz_accuracy f32 [m]; vert_accuracy f32 [m]; ignore_flags u16; time_week u16; gps_id u8; "
     "fix_type u8; satellites_visible u8; +yaw u16 [cdeg]"},
    {233, "GPS_RTCM_DATA", 35, 182, 182,
     "flags u8; len u8 [bytes]; data u8[180]"},
    {235, "HIGH_LATENCY2", 179, 42, 42,
     "timestamp u32 [ms]; latitude i32 [degE7]; longitude i32 [degE7]; custom_mode u16; altitude "
     "i16 [m]; target_altitude i16 [m]; target_distance u16 [dam]; wp_num u16; failure_flags "
     "u16; type u8; autopilot u8; heading u8 [deg/2]; target_heading u8 [deg/2]; throttle u8 "
     "[%]; airspeed u8 [m/s*5]; airspeed_sp u8 [m/s*5]; groundspeed u8 [m/s*5]; windspeed u8 "
     "[m/s*5]; wind_heading u8 [deg/2]; eph u8 [dm]; epv u8 [dm]; temperature_air i8 [degC]; "
     "climb_rate i8 [dm/s]; battery i8 [%]; custom0 i8; custom1 i8; custom2 i8"},
    {241, "VIBRATION", 90, 32, 32,
     "time_usec u64 [us]; vibration_x f32; vibration_y f32; vibration_z f32; clipping_0 u32; "
     "clipping_1 u32; clipping_2 u32"},
    {242, "HOME_POSITION", 104, 52, 60,
     "latitude i32 [degE7]; longitude i32 [degE7]; altitude i32 [mm]; x f32 [m]; y f32 [m]; z "
     "f32 [m]; q f32[4]; approach_x f32 [m]; approach_y f32 [m]; approach_z f32 [m]; +time_usec "
     "u64 [us]"},
    {243, "SET_HOME_POSITION", 85, 53, 61,
     "latitude i32 [degE7]; longitude i32 [degE7]; altitude i32 [mm]; x f32 [m]; y f32 [m]; z "
     "f32 [m]; q f32[4]; approach_x f32 [m]; approach_y f32 [m]; approach_z f32 [m]; "
     "target_system u8; +time_usec u64 [us]"},
    {244, "MESSAGE_INTERVAL", 95, 6, 6,
     "interval_us i32 [us]; message_id u16"},
    {245, "EXTENDED_SYS_STATE", 130, 2, 2,
     "vtol_state u8; landed_state u8"},
    {246, "ADSB_VEHICLE", 184, 38, 38,
     "ICAO_address u32; lat i32 [degE7]; lon i32 [degE7]; altitude i32 [mm]; heading u16 [cdeg]; "
     "hor_velocity u16 [cm/s]; ver_velocity i16 [cm/s]; flags u16; squawk u16; altitude_type u8; "
     "callsign char[9]; emitter_type u8; tslc u8 [s]"},
    {247, "COLLISION", 81, 19, 19,
     "id u32; time_to_minimum_delta f32 [s]; altitude_minimum_delta f32 [m]; "
     "horizontal_minimum_delta f32 [m]; src u8; action u8; threat_level u8"},
    {248, "V2_EXTENSION", 8, 254, 254,
     "message_type u16; target_network u8; target_system u8; target_component u8; payload "
     "u8[249]"},
    {250, "DEBUG_VECT", 49, 30, 30,
     "time_usec u64 [us]; x f32; y f32; z f32; name char[10]"},
    {251, "NAMED_VALUE_FLOAT", 170, 18, 18,
     "time_boot_ms u32 [ms]; value f32; name char[10]"},
    {252, "NAMED_VALUE_INT", 44, 18, 18,
     "time_boot_ms u32 [ms]; value i32; name char[10]"},
    {253, "STATUSTEXT", 83, 51, 54,
     "severity u8; text char[50]; +id u16; +chunk_seq u8"},
    {254, "DEBUG", 46, 9, 9,
     "time_boot_ms u32 [ms]; value f32; ind u8"},
    {256, "SETUP_SIGNING", 71, 42, 42,
     "initial_timestamp u64; target_system u8; target_component u8; secret_key u8[32]"},
    {259, "CAMERA_INFORMATION", 92, 235, 236,
     "time_boot_ms u32 [ms]; firmware_version u32; focal_length f32 [mm]; sensor_size_h f32 "
     "[mm]; sensor_size_v f32 [mm]; flags u32; resolution_h u16 [pix]; resolution_v u16 [pix]; "
     "cam_definition_version u16; vendor_name u8[32]; model_name u8[32]; lens_id u8; "
     "cam_definition_uri char[140]; +gimbal_device_id u8"},
    {260, "CAMERA_SETTINGS", 146, 5, 13,
     "time_boot_ms u32 [ms]; mode_id u8; +zoomLevel f32; +focusLevel f32"},
    {261, "STORAGE_INFORMATION", 179, 27, 60,
     "time_boot_ms u32 [ms]; total_capacity f32 [MiB]; used_capacity f32 [MiB]; "
     "available_capacity f32 [MiB]; read_speed f32 [MiB/s]; write_speed f32 [MiB/s]; storage_id "
     "u8; storage_count u8; status u8; +type u8; +name char[32]"},
    {262, "CAMERA_CAPTURE_STATUS", 12, 18, 22,
     "time_boot_ms u32 [ms]; image_interval f32 [s]; recording_time_ms u32 [ms]; "
     "available_capacity f32 [MiB]; image_status u8; video_status u8; +image_count i32"},
    {263, "CAMERA_IMAGE_CAPTURED", 133, 255, 255,
     "time_utc u64 [us]; time_boot_ms u32 [ms]; lat i32 [degE7]; lon i32 [degE7]; alt i32 [mm]; "
     "relative_alt i32 [mm]; q f32[4]; image_index i32; camera_id u8; capture_result i8; "
     "file_url char[205]"},
    {264, "FLIGHT_INFORMATION", 49, 28, 32,
     "arming_time_utc u64 [us]; takeoff_time_utc u64 [us]; flight_uuid u64; time_boot_ms u32 "
     "[ms]; +landing_time u32 [ms]"},
    {265, "MOUNT_ORIENTATION", 26, 16, 20,
     "time_boot_ms u32 [ms]; roll f32 [deg]; pitch f32 [deg]; yaw f32 [deg]; +yaw_absolute f32 "
     "[deg]"},
    {269, "VIDEO_STREAM_INFORMATION", 109, 213, 214,
     "framerate f32 [Hz]; bitrate u32 [bits/s]; flags u16; resolution_h u16 [pix]; resolution_v "
     "u16 [pix]; rotation u16 [deg]; hfov u16 [deg]; stream_id u8; count u8; type u8; name "
     "char[32]; uri char[160]; +encoding u8"},
    {270, "VIDEO_STREAM_STATUS", 59, 19, 20,
     "framerate f32 [Hz]; bitrate u32 [bits/s]; flags u16; resolution_h u16 [pix]; resolution_v "
     "u16 [pix]; rotation u16 [deg]; hfov u16 [deg]; stream_id u8; +camera_device_id u8"},
    {271, "CAMERA_FOV_STATUS", 22, 52, 52,
     "time_boot_ms u32 [ms]; lat_camera i32 [degE7]; lon_camera i32 [degE7]; alt_camera i32 "
     "[mm]; lat_image i32 [degE7]; lon_image i32 [degE7]; alt_image i32 [mm]; q f32[4]; hfov f32 "
     "[deg]; vfov f32 [deg]"},
    {275, "CAMERA_TRACKING_IMAGE_STATUS", 126, 31, 32,
     "point_x f32; point_y f32; radius f32; rec_top_x f32; rec_top_y f32; rec_bottom_x f32; "
     "rec_bottom_y f32; tracking_status u8; tracking_mode u8; target_data u8; +camera_device_id "
     "u8"},
    {276, "CAMERA_TRACKING_GEO_STATUS", 18, 49, 50,
     "lat i32 [degE7]; lon i32 [degE7]; alt f32 [m]; h_acc f32 [m]; v_acc f32 [m]; vel_n f32 "
     "[m/s]; vel_e f32 [m/s]; vel_d f32 [m/s]; vel_acc f32 [m/s]; dist f32 [m]; hdg f32 [rad]; "
     "hdg_acc f32 [rad]; tracking_status u8; +camera_device_id u8"},
    {277, "CAMERA_THERMAL_RANGE", 62, 30, 30,
     "time_boot_ms u32 [ms]; max f32 [degC]; max_point_x f32; max_point_y f32; min f32 [degC]; "
     "min_point_x f32; min_point_y f32; stream_id u8; camera_device_id u8"},
    {280, "GIMBAL_MANAGER_INFORMATION", 70, 33, 33,
     "time_boot_ms u32 [ms]; cap_flags u32; roll_min f32 [rad]; roll_max f32 [rad]; pitch_min "
     "f32 [rad]; pitch_max f32 [rad]; yaw_min f32 [rad]; yaw_max f32 [rad]; gimbal_device_id u8"},
    {281, "GIMBAL_MANAGER_STATUS", 48, 13, 13,
     "time_boot_ms u32 [ms]; flags u32; gimbal_device_id u8; primary_control_sysid u8; "
     "primary_control_compid u8; secondary_control_sysid u8; secondary_control_compid u8"},
    {282, "GIMBAL_MANAGER_SET_ATTITUDE", 123, 35, 35,
     "flags u32; q f32[4]; angular_velocity_x f32 [rad/s]; angular_velocity_y f32 [rad/s]; "
     "angular_velocity_z f32 [rad/s]; target_system u8; target_component u8; gimbal_device_id u8"},
    {283, "GIMBAL_DEVICE_INFORMATION", 74, 144, 149,
     "uid u64; time_boot_ms u32 [ms]; firmware_version u32; hardware_version u32; roll_min f32 "
     "[rad]; roll_max f32 [rad]; pitch_min f32 [rad]; pitch_max f32 [rad]; yaw_min f32 [rad]; "
     "yaw_max f32 [rad]; cap_flags u16; custom_cap_flags u16; vendor_name char[32]; model_name "
     "char[32]; custom_name char[32]; +gimbal_device_id u8; +cap_flags2 u32"},
    {284, "GIMBAL_DEVICE_SET_ATTITUDE", 99, 32, 32,
     "q f32[4]; angular_velocity_x f32 [rad/s]; angular_velocity_y f32 [rad/s]; "
     "angular_velocity_z f32 [rad/s]; flags u16; target_system u8; target_component u8"},
    {285, "GIMBAL_DEVICE_ATTITUDE_STATUS", 137, 40, 49,
     "time_boot_ms u32 [ms]; q f32[4]; angular_velocity_x f32 [rad/s]; angular_velocity_y f32 "
     "[rad/s]; angular_velocity_z f32 [rad/s]; failure_flags u32; flags u16; target_system u8; "
     "target_component u8; +delta_yaw f32 [rad]; +delta_yaw_velocity f32 [rad/s]; "
     "+gimbal_device_id u8"},
    {286, "AUTOPILOT_STATE_FOR_GIMBAL_DEVICE", 210, 53, 57,
     "time_boot_us u64 [us]; q f32[4]; q_estimated_delay_us u32 [us]; vx f32 [m/s]; vy f32 "
     "[m/s]; vz f32 [m/s]; v_estimated_delay_us u32 [us]; feed_forward_angular_velocity_z f32 "
     "[rad/s]; estimator_status u16; target_system u8; target_component u8; landed_state u8; "
     "+angular_velocity_z f32 [rad/s]"},
    {287, "GIMBAL_MANAGER_SET_PITCHYAW", 1, 23, 23,
     "flags u32; pitch f32 [rad]; yaw f32 [rad]; pitch_rate f32 [rad/s]; yaw_rate f32 [rad/s]; "
     "target_system u8; target_component u8; gimbal_device_id u8"},
    {288, "GIMBAL_MANAGER_SET_MANUAL_CONTROL", 20, 23, 23,
     "flags u32; pitch f32; yaw f32; pitch_rate f32; yaw_rate f32; target_system u8; "
     "target_component u8; gimbal_device_id u8"},
    {301, "AIS_VESSEL", 243, 58, 58,
     "MMSI u32; lat i32 [degE7]; lon i32 [degE7]; COG u16 [cdeg]; heading u16 [cdeg]; velocity "
     "u16 [cm/s]; dimension_bow u16 [m]; dimension_stern u16 [m]; tslc u16 [s]; flags u16; "
     "turn_rate i8 [ddeg/s]; navigational_status u8; type u8; dimension_port u8 [m]; "
     "dimension_starboard u8 [m]; callsign char[7]; name char[20]"},
    {320, "PARAM_EXT_REQUEST_READ", 243, 20, 20,
     "param_index i16; target_system u8; target_component u8; param_id char[16]"},
    {321, "PARAM_EXT_REQUEST_LIST", 88, 2, 2,
     "target_system u8; target_component u8"},
    {322, "PARAM_EXT_VALUE", 243, 149, 149,
     "param_count u16; param_index u16; param_id char[16]; param_value char[128]; param_type u8"},
    {323, "PARAM_EXT_SET", 78, 147, 147,
     "target_system u8; target_component u8; param_id char[16]; param_value char[128]; "
     "param_type u8"},
    {324, "PARAM_EXT_ACK", 132, 146, 146,
     "param_id char[16]; param_value char[128]; param_type u8; param_result u8"},
    {330, "OBSTACLE_DISTANCE", 23, 158, 167,
     "time_usec u64 [us]; distances u16[72] [cm]; min_distance u16 [cm]; max_distance u16 [cm]; "
     "sensor_type u8; increment u8 [deg]; +increment_f f32 [deg]; +angle_offset f32 [deg]; "
     "+frame u8"},
    {331, "ODOMETRY", 91, 230, 233,
     "time_usec u64 [us]; x f32 [m]; y f32 [m]; z f32 [m]; q f32[4]; vx f32 [m/s]; vy f32 [m/s]; "
     "vz f32 [m/s]; rollspeed f32 [rad/s]; pitchspeed f32 [rad/s]; yawspeed f32 [rad/s]; "
     "pose_covariance f32[21]; velocity_covariance f32[21]; frame_id u8; child_frame_id u8; "
     "+reset_counter u8; +estimator_type u8; +quality i8 [%]"},
    {385, "TUNNEL", 147, 133, 133,
     "payload_type u16; target_system u8; target_component u8; payload_length u8; payload "
     "u8[128]"},
    {395, "COMPONENT_INFORMATION", 0, 212, 212,
     "time_boot_ms u32 [ms]; general_metadata_file_crc u32; peripherals_metadata_file_crc u32; "
     "general_metadata_uri char[100]; peripherals_metadata_uri char[100]"},
    {396, "COMPONENT_INFORMATION_BASIC", 50, 160, 160,
     "capabilities u64; time_boot_ms u32 [ms]; time_manufacture_s u32 [s]; vendor_name char[32]; "
     "model_name char[32]; software_version char[24]; hardware_version char[24]; serial_number "
     "char[32]"},
    {435, "AVAILABLE_MODES", 134, 46, 46,
     "custom_mode u32; properties u32; number_modes u8; mode_index u8; standard_mode u8; "
     "mode_name char[35]"},
    {436, "CURRENT_MODE", 193, 9, 9,
     "custom_mode u32; intended_custom_mode u32; standard_mode u8"},
    {437, "AVAILABLE_MODES_MONITOR", 30, 1, 1,
     "seq u8"},
    {11038, "WATER_DEPTH", 47, 38, 38,
     "time_boot_ms u32 [ms]; lat i32 [degE7]; lng i32 [degE7]; alt f32 [m]; roll f32 [rad]; "
     "pitch f32 [rad]; yaw f32 [rad]; distance f32 [m]; temperature f32 [degC]; id u8; healthy "
     "u8"},
};
// clang-format on

}  // namespace

std::span<const TableRow> table_rows() { return kRows; }

}  // namespace watersky::mavlink::detail
