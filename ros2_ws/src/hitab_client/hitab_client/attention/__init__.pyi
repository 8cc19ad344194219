from .attention import Attention as Attention
from .attention import Seen as Seen
from .items import Finding as Finding
from .items import Item as Item
from .items import Kind as Kind
from .items import ranked as ranked
from .listener import AttentionListener as AttentionListener
