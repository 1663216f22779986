// SPDX-License-Identifier: MIT
/// The IMC messages that we know: extend the table, nothing else.
///
/// Names, ids and order are those of IMC.xml 5.4.31 (LSTS/imc), the fields as they lie in the
/// payload. Types are u8 to u32, i8 to i64, f32, f64, raw (bytes), text, message and list, the
/// last two with <Type> where only that message, or one of that group, is meant; the unit follows
/// in brackets. AisInfo.course is without one: degrees in LSTS's schema, radians in DUNE's.
#include "watersky/wire/detail/imc_table.hpp"

namespace watersky::imc::detail {

namespace {

// clang-format off
constexpr TableRow kRows[] = {
    // id, name, fields
    {1, "EntityState", "state u8; flags u8; description text"},
    {2, "QueryEntityState", ""},
    {3, "EntityInfo", "id u8; label text; component text; act_time u16 [s]; deact_time u16 [s]"},
    {4, "QueryEntityInfo", "id u8"},
    {5, "EntityList", "op u8; list text"},
    {7, "CpuUsage", "value u8 [%]"},
    {8, "TransportBindings", "consumer text; message_id u16"},
    {9, "RestartSystem", "type u8"},
    {20, "MsgList", "msgs list"},
    {50, "SimulatedState",
     "lat f64 [rad]; lon f64 [rad]; height f32 [m]; x f32 [m]; y f32 [m]; z f32 [m]; phi f32 "
     "[rad]; theta f32 [rad]; psi f32 [rad]; u f32 [m/s]; v f32 [m/s]; w f32 [m/s]; p f32 "
     "[rad/s]; q f32 [rad/s]; r f32 [rad/s]; svx f32 [m/s]; svy f32 [m/s]; svz f32 [m/s]"},
    {100, "StorageUsage", "available u32 [MiB]; value u8 [%]"},
    {102, "LoggingControl", "op u8; name text"},
    {103, "LogBookEntry", "type u8; htime f64 [s]; context text; text text"},
    {104, "LogBookControl", "command u8; htime f64 [s]; msg list<LogBookEntry>"},
    {150, "Heartbeat", ""},
    {151, "Announce",
     "sys_name text; sys_type u8; owner u16; lat f64 [rad]; lon f64 [rad]; height f32 [m]; "
     "services text"},
    {152, "AnnounceService", "service text; service_type u8"},
    {153, "RSSI", "value f32 [%]"},
    {160, "TextMessage", "origin text; text text"},
    {171, "IridiumMsgTx", "req_id u16; ttl u16 [s]; destination text; data raw"},
    {181, "SystemGroup", "GroupName text; Action u8; GroupList text"},
    {184, "HistoricData",
     "base_lat f32 [°]; base_lon f32 [°]; base_time f32 [s]; data list<RemoteData>"},
    {186, "HistoricSample",
     "sys_id u16; priority i8; x i16 [m]; y i16 [m]; z i16 [dm]; t i16 [s]; sample message"},
    {187, "HistoricDataQuery", "req_id u16; type u8; max_size u16; data message<HistoricData>"},
    {188, "RemoteCommand", "original_source u16; destination u16; timeout f64 [s]; cmd message"},
    {250, "Rpm", "value i16 [rpm]"},
    {251, "Voltage", "value f32 [V]"},
    {252, "Current", "value f32 [A]"},
    {253, "GpsFix",
     "validity u16; type u8; utc_year u16; utc_month u8; utc_day u8; utc_time f32 [s]; lat f64 "
     "[rad]; lon f64 [rad]; height f32 [m]; satellites u8; cog f32 [rad]; sog f32 [m/s]; hdop "
     "f32; vdop f32; hacc f32 [m]; vacc f32 [m]"},
    {254, "EulerAngles",
     "time f64 [s]; phi f64 [rad]; theta f64 [rad]; psi f64 [rad]; psi_magnetic f64 [rad]"},
    {256, "AngularVelocity", "time f64 [s]; x f64 [rad/s]; y f64 [rad/s]; z f64 [rad/s]"},
    {257, "Acceleration", "time f64 [s]; x f64 [m/s/s]; y f64 [m/s/s]; z f64 [m/s/s]"},
    {258, "MagneticField", "time f64 [s]; x f64 [G]; y f64 [G]; z f64 [G]"},
    {259, "GroundVelocity", "validity u8; x f64 [m/s]; y f64 [m/s]; z f64 [m/s]"},
    {262, "Distance",
     "validity u8; location list<DeviceState>; beam_config list<BeamConfig>; value f32 [m]"},
    {263, "Temperature", "value f32 [°C]"},
    {264, "Pressure", "value f64 [hPa]"},
    {271, "WindSpeed", "direction f32 [rad]; speed f32 [m/s]; turbulence f32 [m/s]"},
    {272, "RelativeHumidity", "value f32"},
    {273, "DevDataText", "value text"},
    {274, "DevDataBinary", "value raw"},
    {276, "SonarData",
     "type u8; frequency u32 [Hz]; min_range u16 [m]; max_range u16 [m]; bits_per_point u8 "
     "[bit]; scale_factor f32; beam_config list<BeamConfig>; data raw"},
    {279, "FuelLevel", "value f32 [%]; confidence f32 [%]; opmodes text"},
    {280, "GpsNavData",
     "itow u32 [ms]; lat f64 [rad]; lon f64 [rad]; height_ell f32 [m]; height_sea f32 [m]; hacc "
     "f32 [m]; vacc f32 [m]; vel_n f32 [m/s]; vel_e f32 [m/s]; vel_d f32 [m/s]; speed f32 [m/s]; "
     "gspeed f32 [m/s]; heading f32 [rad]; sacc f32 [m/s]; cacc f32 [rad]"},
    {281, "ServoPosition", "id u8; value f32 [rad]"},
    {282, "DeviceState",
     "x f32 [m]; y f32 [m]; z f32 [m]; phi f32 [rad]; theta f32 [rad]; psi f32 [rad]"},
    {283, "BeamConfig", "beam_width f32 [rad]; beam_height f32 [rad]"},
    {294, "ExternalNavData", "state message<EstimatedState>; type u8"},
    {297, "Throttle", "value f64 [%]"},
    {300, "CameraZoom", "id u8; zoom u8; action u8"},
    {308, "PowerOperation", "op u8; time_remain f32 [s]; sched_time f64 [s]"},
    {309, "PowerChannelControl", "name text; op u8; sched_time f64 [s]"},
    {310, "QueryPowerChannelState", ""},
    {311, "PowerChannelState", "name text; state u8"},
    {350, "EstimatedState",
     "lat f64 [rad]; lon f64 [rad]; height f32 [m]; x f32 [m]; y f32 [m]; z f32 [m]; phi f32 "
     "[rad]; theta f32 [rad]; psi f32 [rad]; u f32 [m/s]; v f32 [m/s]; w f32 [m/s]; vx f32 "
     "[m/s]; vy f32 [m/s]; vz f32 [m/s]; p f32 [rad/s]; q f32 [rad/s]; r f32 [rad/s]; depth f32 "
     "[m]; alt f32 [m]"},
    {351, "EstimatedStreamVelocity", "x f64 [m/s]; y f64 [m/s]; z f64 [m/s]"},
    {352, "IndicatedSpeed", "value f64 [m/s]"},
    {353, "TrueSpeed", "value f64 [m/s]"},
    {354, "NavigationUncertainty",
     "x f32 [m]; y f32 [m]; z f32 [m]; phi f32 [rad]; theta f32 [rad]; psi f32 [rad]; p f32 "
     "[rad/s]; q f32 [rad/s]; r f32 [rad/s]; u f32 [m/s]; v f32 [m/s]; w f32 [m/s]; bias_psi f32 "
     "[rad]; bias_r f32 [rad/s]"},
    {361, "AlignmentState", "state u8"},
    {363, "Airflow", "va f32 [m/s]; aoa f32 [rad]; ssa f32 [rad]"},
    {400, "DesiredHeading", "value f64 [rad]"},
    {401, "DesiredZ", "value f32 [m]; z_units u8"},
    {402, "DesiredSpeed", "value f64; speed_units u8"},
    {403, "DesiredRoll", "value f64 [rad]"},
    {404, "DesiredPitch", "value f64 [rad]"},
    {405, "DesiredVerticalRate", "value f64 [m/s]"},
    {406, "DesiredPath",
     "path_ref u32; start_lat f64 [rad]; start_lon f64 [rad]; start_z f32 [m]; start_z_units u8; "
     "end_lat f64 [rad]; end_lon f64 [rad]; end_z f32 [m]; end_z_units u8; speed f32; "
     "speed_units u8; lradius f32 [m]; flags u8"},
    {408, "DesiredHeadingRate", "value f64 [rad/s]"},
    {409, "DesiredVelocity",
     "u f64 [m/s]; v f64 [m/s]; w f64 [m/s]; p f64 [m/s]; q f64 [m/s]; r f64 [m/s]; flags u8"},
    {410, "PathControlState",
     "path_ref u32; start_lat f64 [rad]; start_lon f64 [rad]; start_z f32 [m]; start_z_units u8; "
     "end_lat f64 [rad]; end_lon f64 [rad]; end_z f32 [m]; end_z_units u8; lradius f32 [m]; "
     "flags u8; x f32 [m]; y f32 [m]; z f32 [m]; vx f32 [m/s]; vy f32 [m/s]; vz f32 [m/s]; "
     "course_error f32 [rad]; eta u16 [s]"},
    {413, "Brake", "op u8"},
    {415, "DesiredThrottle", "value f64 [%]"},
    {450, "Goto",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; roll f64 [rad]; pitch f64 [rad]; yaw f64 [rad]; custom text"},
    {451, "PopUp",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; duration u16 [s]; radius f32 [m]; flags u8; custom text"},
    {452, "Teleoperation", "custom text"},
    {453, "Loiter",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; duration u16 [s]; "
     "speed f32; speed_units u8; type u8; radius f32 [m]; length f32 [m]; bearing f64 [rad]; "
     "direction u8; custom text"},
    {454, "IdleManeuver", "duration u16 [s]; custom text"},
    {455, "LowLevelControl", "control message<ControlCommand>; duration u16 [s]; custom text"},
    {456, "Rows",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; bearing f64 [rad]; cross_angle f64 [rad]; width f32 [m]; length f32 [m]; "
     "hstep f32 [m]; coff u8 [m]; alternation u8 [%]; flags u8; custom text"},
    {457, "FollowPath",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; points list<PathPoint>; custom text"},
    {458, "PathPoint", "x f32 [m]; y f32 [m]; z f32 [m]"},
    {459, "YoYo",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; amplitude f32 [m]; "
     "pitch f32 [rad]; speed f32; speed_units u8; custom text"},
    {461, "StationKeeping",
     "lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; radius f32 [m]; duration u16 [s]; "
     "speed f32; speed_units u8; custom text"},
    {462, "Elevator",
     "timeout u16 [s]; flags u8; lat f64 [rad]; lon f64 [rad]; start_z f32 [m]; start_z_units "
     "u8; end_z f32 [m]; end_z_units u8; radius f32 [m]; speed f32; speed_units u8; custom text"},
    {463, "FollowTrajectory",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; points list<TrajectoryPoint>; custom text"},
    {464, "TrajectoryPoint", "x f32 [m]; y f32 [m]; z f32 [m]; t f32 [s]"},
    {465, "CustomManeuver", "timeout u16 [s]; name text; custom text"},
    {466, "VehicleFormation",
     "lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; speed_units u8; points "
     "list<TrajectoryPoint>; participants list<VehicleFormationParticipant>; start_time f64 [s]; "
     "custom text"},
    {467, "VehicleFormationParticipant", "vid u16; off_x f32 [m]; off_y f32 [m]; off_z f32 [m]"},
    {468, "StopManeuver", ""},
    {470, "ManeuverControlState", "state u8; eta u16 [s]; info text"},
    {471, "FollowSystem",
     "system u16; duration u16 [s]; speed f32; speed_units u8; x f32; y f32; z f32; z_units u8"},
    {472, "CommsRelay",
     "lat f64 [rad]; lon f64 [rad]; speed f32; speed_units u8; duration u16 [s]; sys_a u16; "
     "sys_b u16; move_threshold f32 [m]"},
    {473, "CoverArea",
     "lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; speed_units u8; polygon "
     "list<PolygonVertex>; custom text"},
    {474, "PolygonVertex", "lat f64 [rad]; lon f64 [rad]"},
    {475, "CompassCalibration",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; pitch f32 [rad]; "
     "amplitude f32 [m]; duration u16 [s]; speed f32; speed_units u8; radius f32 [m]; direction "
     "u8; custom text"},
    {477, "FormationPlanExecution",
     "group_name text; formation_name text; plan_id text; description text; leader_speed f32 "
     "[m/s]; leader_bank_lim f32 [m/s]; pos_sim_err_lim f32 [m]; pos_sim_err_wrn f32 [m]; "
     "pos_sim_err_timeout u16 [s]; converg_max f32 [m]; converg_timeout u16 [s]; comms_timeout "
     "u16 [s]; turb_lim f32 [m/s]; custom text"},
    {478, "FollowReference",
     "control_src u16; control_ent u8; timeout f32; loiter_radius f32; altitude_interval f32"},
    {479, "Reference",
     "flags u8; speed message<DesiredSpeed>; z message<DesiredZ>; lat f64; lon f64; radius f32"},
    {480, "FollowRefState",
     "control_src u16; control_ent u8; reference message<Reference>; state u8; proximity u8"},
    {483, "Dislodge", "timeout u16 [s]; rpm f32; direction u8; custom text"},
    {485, "Launch",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; custom text"},
    {486, "Drop",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; custom text"},
    {487, "ScheduledGoto",
     "arrival_time f64 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; travel_z f32 "
     "[m]; travel_z_units u8; delayed u8"},
    {488, "RowsCoverage",
     "lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; speed_units u8; bearing "
     "f64 [rad]; cross_angle f64 [rad]; width f32 [m]; length f32 [m]; coff u8 [m]; angAperture "
     "f32 [rad]; range u16 [m]; overlap u8 [%]; flags u8; custom text"},
    {489, "Sample",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; syringe0 u8; syringe1 u8; syringe2 u8; custom text"},
    {490, "ImageTracking", ""},
    {491, "Takeoff",
     "lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; speed_units u8; "
     "takeoff_pitch f32 [rad]; custom text"},
    {492, "Land",
     "lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; speed_units u8; abort_z "
     "f32 [m]; bearing f64 [rad]; glide_slope u8 [%]; glide_slope_alt f32 [m]; custom text"},
    {493, "AutonomousSection",
     "lat f64 [rad]; lon f64 [rad]; speed f32; speed_units u8; limits u8; max_depth f64 [m]; "
     "min_alt f64 [m]; time_limit f64 [s]; area_limits list<PolygonVertex>; controller text; "
     "custom text"},
    {494, "FollowPoint",
     "target text; max_speed f32 [m/s]; speed_units u8; lat f64 [rad]; lon f64 [rad]; z f32 [m]; "
     "z_units u8; custom text"},
    {495, "Alignment",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; speed f32; speed_units u8; custom text"},
    {496, "StationKeepingExtended",
     "lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; radius f32 [m]; duration u16 [s]; "
     "speed f32; speed_units u8; popup_period u16 [s]; popup_duration u16 [s]; flags u8; custom "
     "text"},
    {497, "ManeuverDone", ""},
    {499, "Magnetometer",
     "timeout u16 [s]; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; speed f32; "
     "speed_units u8; bearing f64 [rad]; width f32 [m]; direction u8; custom text"},
    {500, "VehicleState",
     "op_mode u8; error_count u8; error_ents text; maneuver_type u16; maneuver_stime f64 [s]; "
     "maneuver_eta u16 [s]; control_loops u32; flags u8; last_error text; last_error_time f64 "
     "[s]"},
    {501, "VehicleCommand",
     "type u8; request_id u16; command u8; maneuver message<Maneuver>; calib_time u16 [s]; info "
     "text"},
    {504, "OperationalLimits",
     "mask u8; max_depth f32 [m]; min_altitude f32 [m]; max_altitude f32 [m]; min_speed f32 "
     "[m/s]; max_speed f32 [m/s]; max_vrate f32 [m/s]; lat f64 [rad]; lon f64 [rad]; orientation "
     "f32 [rad]; width f32 [m]; length f32 [m]"},
    {506, "Calibration", "duration u16 [s]"},
    {507, "ControlLoops", "enable u8; mask u32; scope_ref u32"},
    {508, "VehicleMedium", "medium u8"},
    {509, "Collision", "value f32 [m/s/s]; type u8"},
    {511, "AutopilotMode", "autonomy u8; mode text"},
    {513, "ReportControl", "op u8; comm_interface u8; period u16 [s]; sys_dst text"},
    {514, "StateReport",
     "stime u32 [s]; latitude f32 [°]; longitude f32 [°]; altitude u16 [dm]; depth u16 [dm]; "
     "heading u16; speed i16 [cm/s]; fuel i8 [%]; exec_state i8 [%]; plan_checksum u16"},
    {515, "TransmissionRequest",
     "req_id u16; comm_mean u8; destination text; deadline f64; range f32 [m]; data_mode u8; "
     "msg_data message; txt_data text; raw_data raw"},
    {516, "TransmissionStatus", "req_id u16; status u8; range f32 [m]; info text"},
    {517, "SmsRequest", "req_id u16; destination text; timeout f64 [s]; sms_text text"},
    {518, "SmsStatus", "req_id u16; status u8; info text"},
    {519, "VtolState", "state u8"},
    {520, "ArmingState", "state u8"},
    {550, "Abort", ""},
    {551, "PlanSpecification",
     "plan_id text; description text; vnamespace text; variables list<PlanVariable>; "
     "start_man_id text; maneuvers list<PlanManeuver>; transitions list<PlanTransition>; "
     "start_actions list; end_actions list"},
    {552, "PlanManeuver",
     "maneuver_id text; data message<Maneuver>; start_actions list; end_actions list"},
    {553, "PlanTransition", "source_man text; dest_man text; conditions text; actions list"},
    {556, "PlanDB", "type u8; op u8; request_id u16; plan_id text; arg message; info text"},
    {557, "PlanDBState",
     "plan_count u16; plan_size u32; change_time f64 [s]; change_sid u16; change_sname text; md5 "
     "raw; plans_info list<PlanDBInformation>"},
    {558, "PlanDBInformation",
     "plan_id text; plan_size u16; change_time f64; change_sid u16; change_sname text; md5 raw"},
    {559, "PlanControl",
     "type u8; op u8; request_id u16; plan_id text; flags u16; arg message; info text"},
    {560, "PlanControlState",
     "state u8; plan_id text; plan_eta i32 [s]; plan_progress f32 [%]; man_id text; man_type "
     "u16; man_eta i32 [s]; last_outcome u8"},
    {561, "PlanVariable", "name text; value text; type u8; access u8"},
    {562, "PlanGeneration", "cmd u8; op u8; plan_id text; params text"},
    {564, "PlanStatistics",
     "plan_id text; type u8; properties u8; durations text; distances text; actions text; fuel "
     "text"},
    {600, "ReportedState",
     "lat f64 [rad]; lon f64 [rad]; depth f64 [m]; roll f64 [rad]; pitch f64 [rad]; yaw f64 "
     "[rad]; rcp_time f64 [s]; sid text; s_type u8"},
    {601, "RemoteSensorInfo",
     "id text; sensor_class text; lat f64 [rad]; lon f64 [rad]; alt f32 [m]; heading f32 [rad]; "
     "data text"},
    {602, "Map", "id text; features list<MapFeature>"},
    {603, "MapFeature",
     "id text; feature_type u8; rgb_red u8; rgb_green u8; rgb_blue u8; feature list<MapPoint>"},
    {604, "MapPoint", "lat f64 [rad]; lon f64 [rad]; alt f32 [m]"},
    {606, "CcuEvent", "type u8; id text; arg message"},
    {650, "VehicleLinks", "localname text; links list<Announce>"},
    {651, "TrexObservation", "timeline text; predicate text; attributes text"},
    {655, "TrexOperation", "op u8; goal_id text; token message<TrexToken>"},
    {656, "TrexAttribute", "name text; attr_type u8; min text; max text"},
    {657, "TrexToken", "timeline text; predicate text; attributes list<TrexAttribute>"},
    {660, "Event", "topic text; data text"},
    {702, "CompressedImage", "frameid u8; data raw"},
    {703, "ImageTxSettings", "fps u8; quality u8; reps u8; tsize u8"},
    {750, "RemoteState",
     "lat f32 [rad]; lon f32 [rad]; depth u8 [m]; speed f32 [m/s]; psi f32 [rad]"},
    {800, "Target",
     "label text; lat f64 [rad]; lon f64 [rad]; z f32 [m]; z_units u8; cog f32 [rad]; sog f32 "
     "[m/s]"},
    {801, "EntityParameter", "name text; value text"},
    {802, "EntityParameters", "name text; params list<EntityParameter>"},
    {803, "QueryEntityParameters", "name text; visibility text; scope text"},
    {804, "SetEntityParameters", "name text; params list<EntityParameter>"},
    {805, "SaveEntityParameters", "name text"},
    {811, "PushEntityParameters", "name text"},
    {812, "PopEntityParameters", "name text"},
    {814, "UamTxFrame", "seq u16; sys_dst text; flags u8; data raw"},
    {877, "MessagePart", "uid u8; frag_number u8; num_frags u8; data raw"},
    {878, "MessagePartControl", "uid u8; op u8; frag_ids text"},
    {889, "Aborted", ""},
    {892, "UsblFix", "target u16; lat f64 [rad]; lon f64 [rad]; z_units u8; z f32 [m]"},
    {895, "SetImageCoords", "camId u8; x u16 [px]; y u16 [px]"},
    {896, "GetImageCoords", "camId u8; x u16 [px]; y u16 [px]"},
    {897, "GetWorldCoordinates",
     "tracking u8; lat f64 [rad]; lon f64 [rad]; x f32 [m]; y f32 [m]; z f32 [m]"},
    {906, "ApmStatus", "severity u8; text text"},
    {908, "DmsDetection",
     "ch01 f32; ch02 f32; ch03 f32; ch04 f32; ch05 f32; ch06 f32; ch07 f32; ch08 f32; ch09 f32; "
     "ch10 f32; ch11 f32; ch12 f32; ch13 f32; ch14 f32; ch15 f32; ch16 f32"},
    {909, "HomePosition",
     "op u8; lat f64 [rad]; lon f64 [rad]; height f32 [m]; depth f32 [m]; alt f32 [m]"},
    {911, "AbsoluteWind", "direction f32 [rad]; speed f32 [m/s]; turbulence f32 [m/s]"},
    {912, "AisInfo",
     "msg_type text; sensor_class text; mmsi text; callsign text; name text; nav_status u8; "
     "type_and_cargo u8; lat f64 [rad]; lon f64 [rad]; course f32; speed f32 [kn]; dist "
     "f32 [m]; a f32 [m]; b f32 [m]; c f32 [m]; d f32 [m]; draught f32 [m]"},
    {2000, "GpioState", "name text; value u8"},
    {2017, "TypedEntityParameter",
     "name text; type u8; default_value text; units text; description text; values_list text; "
     "min_value f32; max_value f32; list_min_size u8; list_max_size u8; values_if_list "
     "list<ValuesIf>; visibility u8; scope u8"},
    {2018, "ValuesIf", "param text; value text; values_list text"},
    {2021, "VersionInfo", "op u8; version text; description text"},
    {2036, "TypedEntityParameterEditor", "value text"},
    {2040, "AckMsg", "original message; text text; status u8"},
};

constexpr GroupRow kGroups[] = {
    {"Maneuver",
     "Alignment AutonomousSection CommsRelay CompassCalibration CoverArea CustomManeuver "
     "Dislodge Drop Elevator FollowPath FollowPoint FollowReference FollowTrajectory "
     "FormationPlanExecution Goto IdleManeuver ImageTracking Land Launch Loiter "
     "LowLevelControl Magnetometer PopUp Rows RowsCoverage Sample ScheduledGoto StationKeeping "
     "StationKeepingExtended Takeoff Teleoperation VehicleFormation YoYo"},
    {"ControlCommand",
     "DesiredHeading DesiredPath DesiredPitch DesiredRoll DesiredSpeed DesiredThrottle "
     "DesiredZ"},
    {"RemoteData", "HistoricSample RemoteCommand"},
    {"TypedEntityParametersOptions", "TypedEntityParameter TypedEntityParameterEditor"},
};
// clang-format on

}  // namespace

std::span<const TableRow> table_rows() { return kRows; }
std::span<const GroupRow> group_rows() { return kGroups; }

}  // namespace watersky::imc::detail
