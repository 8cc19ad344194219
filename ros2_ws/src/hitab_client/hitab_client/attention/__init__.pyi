from .attention import Attention as Attention
from .attention import Seen as Seen
from .items import Concern as Concern
from .items import Item as Item
from .items import Kind as Kind
from .items import others_alike as others_alike
from .items import ranked as ranked
from .listener import AttentionListener as AttentionListener
