from .machine_signs import MachineSigns as MachineSigns
from .moving import Move as Move
from .moving import move as move
from .moving import processes_meant as processes_meant
from .swarm_machines import SwarmMachines as SwarmMachines
