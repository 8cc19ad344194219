from . import run_folder as run_folder
from . import run_processes as run_processes
from . import shipped as shipped
from . import swarm_choice as swarm_choice
