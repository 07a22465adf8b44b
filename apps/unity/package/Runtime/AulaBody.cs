using UnityEngine;

namespace Aula
{
    /// The meshes at and below it have a material of their own, and may move.
    public sealed class AulaBody : MonoBehaviour
    {
        /// None: that of the room.
        public AulaMaterial material;
        /// The meshes move with it, rigidly.
        public bool moving;
        /// Off: the meshes are not part of the room.
        public bool audible = true;
    }
}
