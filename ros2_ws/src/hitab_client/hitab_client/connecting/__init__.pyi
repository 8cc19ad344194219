from . import dds_profile as dds_profile
from . import domain_ids as domain_ids
from . import identity as identity
from . import ros_environment as ros_environment
