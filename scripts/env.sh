# Sourced by bash or zsh: the environment that scripts/setup has made, for this shell.
#
#     . scripts/env.sh
#
# HITAB_VENV  where the environment is, instead of .venv in the checkout
# HITAB_ROS   "wheels" for ROS 2 from wheels even where it is installed, or the folder of an
#             installed ROS 2 Jazzy, instead of /opt/ros/jazzy
#
# What another ROS distribution has put into this shell is taken out: the two do not mix.
# shellcheck shell=bash

_hitab_scripts=$(cd "$(dirname "${BASH_SOURCE[0]:-$0}")" && pwd -P)
_hitab_venv=${HITAB_VENV:-${_hitab_scripts%/*}/.venv}
_hitab_ros=${HITAB_ROS:-/opt/ros/jazzy}
_hitab_sources=${_hitab_scripts%/*}/ros2_ws/src
_hitab_measuring=${_hitab_scripts%/*}/research/src

# Prints a list of folders without those inside the folders of another list.
_hitab_without() {
  printf '%s' "$1" | awk -v RS=: -v others="$2" '
    BEGIN { count = split(others, other, ":") }
    {
      for (i = 1; i <= count; i++)
        if (other[i] != "" && index($0 "/", other[i] "/") == 1) next
      if ($0 != "") { printf "%s%s", separator, $0; separator = ":" }
    }'
}

if [ -f "$_hitab_ros/setup.bash" ]; then _hitab_installed=1; else _hitab_installed=; fi

if [ -z "$_hitab_installed" ] || [ "${ROS_DISTRO:-jazzy}" != jazzy ]; then
  _hitab_foreign=${AMENT_PREFIX_PATH:-}:${COLCON_PREFIX_PATH:-}:/opt/ros
  PATH=$(_hitab_without "$PATH" "$_hitab_foreign")
  LD_LIBRARY_PATH=$(_hitab_without "${LD_LIBRARY_PATH:-}" "$_hitab_foreign")
  [ -n "$LD_LIBRARY_PATH" ] || unset LD_LIBRARY_PATH
  unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONPATH RMW_IMPLEMENTATION
  unset ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION ROS_ETC_DIR ROS_PACKAGE_PATH ROS_ROOT _hitab_foreign
fi
# The wheels' start-up file sets the library path unless this says that it has: maybe for another
# environment, so it has to do it again.
unset PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE
# Container images forbid Python to keep what it has compiled. Each process of a swarm would compile
# all of its modules again, which takes longer than the rest of its start.
unset PYTHONDONTWRITEBYTECODE
# Arrays are small here: numpy's own threads cost each command a sixth of a second to start.
export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}" OPENBLAS_NUM_THREADS="${OPENBLAS_NUM_THREADS:-1}"

PATH=$_hitab_venv/bin:$(_hitab_without "$PATH" "$_hitab_venv")
if [ -n "$_hitab_installed" ]; then
  case $- in *u*) _hitab_unset=u ;; *) _hitab_unset= ;; esac
  set +u # the installed setup file reads unset variables
  if [ -n "${ZSH_VERSION:-}" ]; then
    . "$_hitab_ros/setup.zsh"
  else
    . "$_hitab_ros/setup.bash"
  fi
  AMENT_PREFIX_PATH=$_hitab_venv:$(_hitab_without "${AMENT_PREFIX_PATH:-}" "$_hitab_venv")
  LD_LIBRARY_PATH=$_hitab_venv/lib:$(_hitab_without "${LD_LIBRARY_PATH:-}" "$_hitab_venv")
  PATH=$_hitab_venv/bin:$(_hitab_without "$PATH" "$_hitab_venv")
  # `ros2` runs the system's Python, not the environment's: it has to find the packages of this
  # checkout, the messages and what both need. The packages are named one by one, since Python heeds
  # editable installations only in its own folders. What ROS itself has comes before the rest.
  _hitab_packages=$(
    find "$_hitab_sources" "$_hitab_measuring" -mindepth 2 -maxdepth 2 -name setup.py 2>/dev/null |
      LC_ALL=C sort | sed 's|/[^/]*$||' | tr '\n' ':'
  )
  _hitab_site=$(
    find "$_hitab_venv/lib" -maxdepth 2 -path '*/python3*/site-packages' 2>/dev/null | tr '\n' ':'
  )
  PYTHONPATH=$(_hitab_without "${PYTHONPATH:-}" "$_hitab_venv:$_hitab_sources:$_hitab_measuring")
  PYTHONPATH=$(_hitab_without "$_hitab_packages:$PYTHONPATH:$_hitab_site" "")
  unset _hitab_packages _hitab_site
  [ -z "$_hitab_unset" ] || set -u
  export LD_LIBRARY_PATH PYTHONPATH
else
  AMENT_PREFIX_PATH=$_hitab_venv
  export CMAKE_PREFIX_PATH=$_hitab_venv ROS_DISTRO=jazzy ROS_VERSION=2 ROS_PYTHON_VERSION=3
fi
export PATH AMENT_PREFIX_PATH VIRTUAL_ENV="$_hitab_venv" PYTHONNOUSERSITE=1
# Nobody else's robots on the network are meant, unless the user says so. ROS's own LOCALHOST finds
# 32 processes only and listens on all interfaces; this profile finds 120 and binds to 127.0.0.1.
# Without it SYSTEM_DEFAULT would mean the network, so that the two are set together or not at all.
: "${ROS_AUTOMATIC_DISCOVERY_RANGE:=LOCALHOST}"
_hitab_dds=${_hitab_scripts%/*}/ros2_ws/src/hitab_client/hitab_client/connecting/dds_loopback.xml
if [ "$ROS_AUTOMATIC_DISCOVERY_RANGE" = LOCALHOST ] && [ -f "$_hitab_dds" ] &&
  [ -z "${FASTRTPS_DEFAULT_PROFILES_FILE:-}${FASTDDS_DEFAULT_PROFILES_FILE:-}" ]; then
  case ${RMW_IMPLEMENTATION:-rmw_fastrtps_cpp} in
    rmw_fast*)
      ROS_AUTOMATIC_DISCOVERY_RANGE=SYSTEM_DEFAULT
      export FASTRTPS_DEFAULT_PROFILES_FILE=$_hitab_dds FASTDDS_DEFAULT_PROFILES_FILE=$_hitab_dds
      # These give the memory of large messages back, see dds_profile.py.
      export RMW_FASTRTPS_USE_QOS_FROM_XML=1 MALLOC_MMAP_THRESHOLD_=1000000
      ;;
  esac
fi
case $ROS_AUTOMATIC_DISCOVERY_RANGE:${FASTRTPS_DEFAULT_PROFILES_FILE:-} in
  LOCALHOST:* | SYSTEM_DEFAULT:*) ;;
  *:"$_hitab_dds") unset FASTRTPS_DEFAULT_PROFILES_FILE FASTDDS_DEFAULT_PROFILES_FILE ;;
esac
export ROS_AUTOMATIC_DISCOVERY_RANGE

# Matplotlib would write into ~/.config and ~/.cache.
export MPLCONFIGDIR="${MPLCONFIGDIR:-$_hitab_venv/matplotlib}"

if [ -z "${HOME:-}" ]; then export HOME=~; fi # ROS logs there, and does not start without

unset -f _hitab_without
unset _hitab_dds _hitab_measuring _hitab_scripts _hitab_sources _hitab_venv _hitab_ros _hitab_installed _hitab_unset
