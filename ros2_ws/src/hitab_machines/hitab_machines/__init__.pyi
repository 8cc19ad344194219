from .description_transfer import fetch_description as fetch_description
from .joining import await_machines as await_machines
from .joining import refuse_limits as refuse_limits
from .joining import refuse_to_join as refuse_to_join
from .machine_signs import MachineSigns as MachineSigns
from .remote_start import RemoteStarts as RemoteStarts
from .remote_start import local_machine as local_machine
